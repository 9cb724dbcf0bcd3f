#include "server/bake/stage_dump.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>
#include <variant>

#include "common/debug/dump_obj.hpp"
#include "server/bake/engine_around.hpp"
#include "server/bake/output_folders.hpp"

namespace fracture::bake {
namespace {

constexpr std::array kNames{"1-mesh.obj", "2-solid.obj", "3-sites.obj", "4-tetrahedra.obj",
                            "5-fragments.obj"};
constexpr std::size_t kMesh = 0, kSolid = 1, kSites = 2, kTetrahedra = 3, kFragments = 4;

/// Factor by which fragments are moved outwards, relative to their distance from the centre.
constexpr double kDumpExplode = 0.5;
/// Factor by which a tetrahedron's vertices are moved towards its centre, relative to their distance from it.
constexpr double kShrink = 0.1;
/// Radius of a site, relative to the solid's longest side.
constexpr double kSiteRadius = 0.005;

std::string path_of(const std::string& folder, std::size_t stage) {
  return (std::filesystem::path(folder) / kNames[stage]).string();
}

class DumpingEngine final : public EngineAround {
 public:
  DumpingEngine(std::unique_ptr<FractureEngine> inner, std::shared_ptr<StageDump> dump)
      : EngineAround(std::move(inner)), dump_(std::move(dump)) {}

  Expected<Solid> prepare(std::shared_ptr<const Mesh> mesh, const SolidOptions& options,
                          const HollowOptions& hollow, const Execution& execution) const override {
    dump_->write(kMesh, [&](std::ostream& out) { debug::dump_obj(out, *mesh); });
    Expected<Solid> solid = EngineAround::prepare(std::move(mesh), options, hollow, execution);
    if (solid) dump_->write(kSolid, [&](std::ostream& out) { debug::dump_obj(out, *solid); });
    return solid;
  }
  Expected<CutBase> base(const Solid& solid, const FractureParameters& parameters, const Selection& selection,
                         const Execution& execution) const override {
    Expected<CutBase> made = EngineAround::base(solid, parameters, selection, execution);
    if (const Diagram* const diagram = made ? std::get_if<Diagram>(&*made) : nullptr) {
      Tetrahedralization t = diagram->tetrahedralization;
      const auto place = [](const CellMap& map, auto begin,
                            auto end) {  // stretched cells: move them back to the solid
        if (map) std::transform(begin, end, begin, [&](const Vec3d& p) { return map.at(p).place(p); });
      };
      if (diagram->sets.empty()) place(diagram->map, t.points.begin(), t.points.end());
      auto first = t.points.begin();  // the sites of several materials have no common tetrahedra
      for (const Diagram& set : diagram->sets) {
        const auto end = first + set.tetrahedralization.site_count();
        place(set.map, first, end);
        first = end;
      }
      dump_->write(kSites, [&](std::ostream& out) {
        debug::dump_obj_of_sites(out, t, kSiteRadius * solid.box.longest_side());
      });
      dump_->write(kTetrahedra, [&](std::ostream& out) { debug::dump_obj(out, t, kShrink); });
    }
    return made;
  }
  Expected<Cut> cut(const Solid& solid, const CutBase& base, const FractureParameters& parameters,
                    const Selection& selection, const Execution& execution) const override {
    Expected<Cut> made = EngineAround::cut(solid, base, parameters, selection, execution);
    if (made)
      dump_->write(kFragments,
                   [&](std::ostream& out) { debug::dump_obj(out, made->fractured.set, kDumpExplode); });
    return made;
  }

 private:
  const std::shared_ptr<StageDump> dump_;
};

}  // namespace

std::vector<std::string> stage_files(const std::string& folder) {
  std::vector<std::string> files;
  for (std::size_t stage = 0; stage < kNames.size(); ++stage) files.push_back(path_of(folder, stage));
  return files;
}

StageDump::StageDump(std::string folder, std::function<void(const std::string& line)> say)
    : folder_(std::move(folder)), say_(std::move(say)) {}

void StageDump::fail(const std::string& path, int error) {
  say_("cannot write " + path + ": " + std::strerror(error));
  failed_ = true;
}

void StageDump::write(std::size_t stage, const std::function<void(std::ostream&)>& dump) {
  const std::string path = path_of(folder_, stage);
  if (!make_folders_of(path)) return fail(path, errno);
  const int created = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (created < 0) return fail(path, errno);
  ::close(created);
  errno = 0;
  std::ofstream out(path, std::ios::binary);
  dump(out);
  out.close();
  if (!out) fail(path, errno != 0 ? errno : EIO);
}

std::unique_ptr<FractureEngine> dumping_engine(std::unique_ptr<FractureEngine> inner,
                                               std::shared_ptr<StageDump> dump) {
  return std::make_unique<DumpingEngine>(std::move(inner), std::move(dump));
}

}  // namespace fracture::bake
