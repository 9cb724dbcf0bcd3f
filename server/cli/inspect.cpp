// fracture-server inspect: reports what the service would make of meshes, without fracturing them.
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "common/base/json_text.hpp"
#include "common/base/printable.hpp"
#include "common/base/printed_output.hpp"
#include "common/base/words.hpp"
#include "common/contacts/contact_report.hpp"
#include "common/gltf/report_text.hpp"
#include "common/mesh/dropped.hpp"
#include "common/mesh/material_library.hpp"
#include "common/pipeline/overlaps.hpp"
#include "server/bake/failure.hpp"
#include "server/bake/import_workers.hpp"
#include "server/bake/input_file.hpp"
#include "server/bake/mesh_search.hpp"
#include "server/cli/inspect_list.hpp"
#include "server/cli/options.hpp"
#include "server/service/control_group.hpp"
#include "server/service/estimate.hpp"
#include "server/service/mesh_report.hpp"
#include "server/service/worker_pool.hpp"

namespace fracture::cli {
namespace {

/// The part of the report that depends on the parameters of a fracture.
struct ForRequest {
  Remarks remarks;
  std::vector<Choice> choices;
  nlohmann::json estimate;
};

ForRequest for_request(const PreparedMesh& mesh, const FractureRequest& request,
                       const ServiceConfig& config) {
  ForRequest result;
  check_size_of_pieces(mesh, request, result.remarks, result.choices);
  result.estimate =
      estimate_document(request.parameters, mesh.solid, config.max_bytes_per_job, config.memory_setting);
  return result;
}

std::string in_words(const Choice& choice) {
  std::string parameters;
  for (const Choice::Setting& setting : choice.parameters) {
    const auto* const number = std::get_if<double>(&setting.value);
    parameters += "--" + setting.name + " " +
                  (number ? short_number(*number) : std::get<std::string>(setting.value)) + " ";
  }
  return parameters + "(" + choice.kind + "): " + choice.text;
}

/// Volumes that differ by less than this share differ only by rounding.
constexpr double kSameVolume = 1e-8;

/// Returns "from the file", "from the request" or "assumed".
std::string source_of(FrameReport::From from) {
  return from == FrameReport::From::kAssumed ? std::string("assumed")
                                             : std::string("from the ") + name_of(from);
}

/// Returns "unit 1 m and y up, both from the file".
std::string in_words(const FrameReport& frame) {
  char unit[48];
  std::snprintf(unit, sizeof unit, "unit %.9g m", frame.metres_per_unit);
  const std::string up = frame.z_up ? "z up" : "y up";
  if (frame.unit_from == frame.up_from) return unit + (" and " + up) + ", both " + source_of(frame.unit_from);
  return unit + (", " + source_of(frame.unit_from)) + "; " + up + ", " + source_of(frame.up_from);
}

void print(const std::string& input, const PreparedMesh& mesh, const ForRequest& asked, bool mended) {
  const SolidReport& r = mesh.solid.report;
  const Mesh& source = *mesh.solid.source;
  std::printf("%s: %s\n", input.c_str(), mended ? "usable after repair" : "a closed solid as it is");
  const Vec3d size = mesh.solid.box.size();
  std::printf("  size       %.6g x %.6g x %.6g m (%s)\n", size.x, size.y, size.z,
              in_words(mesh.frame).c_str());
  const double once = volume_once(mesh.solid, {});
  std::printf("  volume     %.9g m³", r.volume);
  if (!(std::fabs(once - r.volume) <= kSameVolume * r.volume))
    std::printf(" (%.9g m³ with overlaps counted once)", once);
  std::printf(", area %.9g m²\n", r.area);
  const auto nodes = source.node_names.size(), materials = source.library->materials.size(),
             images = source.library->images.size();
  std::printf("  solid      %s, %s, %s\n", counted(r.parts, "part", "parts").c_str(),
              counted(r.shells, "shell", "shells").c_str(),
              counted(r.cavities, "cavity", "cavities").c_str());
  if (const auto contacts = contact_report(mesh.solid))
    std::printf("  contacts   %s, of which %s; area %.6g m², common volume %.6g m³; %s no other part\n",
                counted(contacts->pairs, "pair of parts touches", "pairs of parts touch").c_str(),
                counted(contacts->overlapping, "overlaps", "overlap").c_str(), contacts->area,
                contacts->volume, counted(contacts->alone, "part touches", "parts touch").c_str());
  std::printf(
      "  source     %s, %s, %s, %s, %s\n", counted(r.source_triangles, "triangle", "triangles").c_str(),
      counted(r.source_vertices, "vertex", "vertices").c_str(), counted(nodes, "node", "nodes").c_str(),
      counted(materials, "material", "materials").c_str(), counted(images, "image", "images").c_str());
  if (source.passed_through)
    std::printf("  not fractured: %s\n",
                counted(source.passed_through->triangles.size(), "triangle", "triangles").c_str());
  if (mended)
    std::printf("  repaired   %s, %s, %s; %.6g m² of surface were added\n",
                counted(r.open_edges, "open edge", "open edges").c_str(),
                counted(r.nonmanifold_edges, "non-manifold edge", "non-manifold edges").c_str(),
                counted(r.holes_filled, "filled hole", "filled holes").c_str(), r.filled_area);
  const auto number = [&](const char* name) { return asked.estimate.at(name).get<std::uint64_t>(); };
  std::printf("  estimate   %s, %s, a file of %s bytes, %s bytes of working memory\n",
              counted(number("fragments"), "fragment", "fragments").c_str(),
              counted(number("triangles"), "triangle", "triangles").c_str(), grouped(number("bytes")).c_str(),
              grouped(number("working_bytes")).c_str());
  Remarks remarks = mesh.solid.remarks();
  remarks.add(asked.remarks);
  for (const std::string& warning : remarks.warnings) std::printf("  warning: %s\n", warning.c_str());
  for (const std::string& note : remarks.notes) std::printf("  note: %s\n", note.c_str());
  for (const Dropped& entry : source.dropped)
    std::printf("  dropped: %s\n", printable(to_text(entry)).c_str());
  for (const auto* choices : {&r.choices, &asked.choices})
    for (const Choice& choice : *choices) std::printf("  choice: %s\n", in_words(choice).c_str());
}

/// The findings about one file.
struct Inspected {
  nlohmann::json report{};  ///< see inspect_list.hpp
  int exit_code = kExitDone;
  std::optional<Error> error{};                ///< why the mesh is refused
  std::shared_ptr<const PreparedMesh> mesh{};  ///< null if it is refused or cannot be read
  ForRequest asked{};
};

Inspected refused(const std::string& input, const Error& error) {
  return {.report = {{"input", input},
                     {"verdict", "refused"},
                     {"error", slug(error.code)},
                     {"detail", error.detail},
                     {"pointer", error.pointer},
                     {"figures", *error.extra}},
          .exit_code = exit_code(error.code),
          .error = error};
}

nlohmann::json report_of(const std::string& input, const PreparedMesh& mesh, const ForRequest& asked) {
  nlohmann::json report = mesh_report(mesh);
  const Vec3d size = mesh.solid.box.size();
  report["input"] = input;
  report["size"] = {size.x, size.y, size.z};
  report["estimate"] = asked.estimate;
  for (const std::string& warning : asked.remarks.warnings) report["warnings"].push_back(warning);
  for (const nlohmann::json& choice : choices_document(asked.choices)) report["choices"].push_back(choice);
  return report;
}

/// Inspects meshes with the same parameters and limits.
class Inspector {
 public:
  Inspector(const InspectOptions& options, const ServiceConfig& config,
            std::unique_ptr<FractureEngine> engine)
      : options_(options), config_(config), service_(config, std::move(engine)) {}

  /// Must return a value before look_at() is called.
  Expected<void> parse() {
    Expected<RequestParameters> parameters = service_.parameters().parse(options_.parameters);
    if (!parameters) return tl::unexpected<Error>(parameters.error());
    parameters_ = std::move(*parameters);
    return {};
  }

  Inspected look_at(const std::string& path) {
    std::optional<std::string> bytes = bake::read_bytes(path);
    if (!bytes)
      return {.report = {{"input", path}, {"verdict", "unreadable"}, {"detail", std::strerror(errno)}},
              .exit_code = kExitSystem};
    const Expected<bake::InputFile> input = bake::to_input(path, std::move(*bytes), parameters_);
    if (!input) return refused(path, input.error());
    Execution execution;
    execution.threads = options_.threads > 0 ? options_.threads : available_cores();
    const FractureRequest request{input->view(), input->format, parameters_,
                                  as_import_files(input->siblings)};
    const auto mesh = service_.prepare(request, execution);
    if (!mesh) return refused(path, mesh.error());
    Inspected found{.exit_code = repaired((*mesh)->solid.report) ? kExitRepaired : kExitDone, .mesh = *mesh};
    found.asked = for_request(**mesh, request, config_);
    found.report = report_of(path, **mesh, found.asked);
    return found;
  }

 private:
  const InspectOptions& options_;
  const ServiceConfig config_;
  FractureService service_;
  RequestParameters parameters_;
};

void complain(const std::string& line) {
  std::fprintf(stderr, "fracture-server inspect: %s\n", printable_lines(line).c_str());
}

int print_one(const InspectOptions& options, const std::string& input, const Inspected& found) {
  if (found.report.at("verdict") == "unreadable")
    complain("cannot read " + input + ": " + found.report.at("detail").get<std::string>());
  else if (options.json)
    std::printf("%s\n", json_text(found.report, 2).c_str());
  else if (found.error)
    std::printf("%s: refused: %s\n", input.c_str(), printable_lines(bake::to_lines(*found.error)).c_str());
  else
    print(input, *found.mesh, found.asked, found.exit_code == kExitRepaired);
  flush_printed();
  return found.exit_code;
}

/// Prints a line for each mesh, and a summary.
int inspect_many(const InspectOptions& options, Inspector& inspector) {
  bake::MeshSearch search;
  for (const std::string& input : options.inputs) {
    if (input == bake::kStandardStream) {
      complain("Standard input ('-') contains one mesh, so it must be the only input.");
      return kExitUsage;
    }
    if (const auto looked = search.look_into(input); !looked) {
      complain(looked.error().detail);
      return kExitUsage;
    }
  }
  if (const std::size_t results = search.skipped().size(); results > 0)
    complain("skipped " + counted(results, "result of an earlier bake", "results of earlier bakes") +
             ", such as " + search.skipped().front());
  InspectSummary summary;
  const auto print_line = [&](const std::string& line) {
    std::printf("%s\n", line.c_str());
    return flush_printed() == 0;  // so that people see the progress
  };
  for (const bake::FoundMesh& mesh : search.found()) {
    const Inspected found = inspector.look_at(mesh.path);
    summary.add(found.report, found.exit_code);
    if (!print_line(options.json ? json_text(found.report) : line_of(found.report))) return kExitSystem;
  }
  for (const std::string& link : search.dangling()) {
    summary.add_dangling(link);
    complain("cannot read " + link + ": " + bake::kDangling);
  }
  if (options.json) {
    print_line(json_text(nlohmann::json{{"summary", summary.document()}}));
  } else {
    for (const std::string& line : summary.lines()) print_line(line);
  }
  return summary.exit_code();
}

}  // namespace

int inspect(const InspectOptions& options) {
  if (options.inputs.empty()) {
    complain("Give a mesh file, a folder or a glob in quotes. Run fracture-server inspect --help.");
    return kExitUsage;
  }
  std::unique_ptr<FractureEngine> engine;
  try {
    engine = make_engine(
        bake::own_import_workers(1, "The limit is half of --memory. Use a smaller mesh, or raise --memory."));
  } catch (const std::runtime_error& e) {
    complain(e.what());
    return kExitSystem;
  }
  // The limits of a bake of one mesh.
  ServiceConfig config = options.service;
  config.max_bytes_per_job = options.memory > 0 ? options.memory : available_memory() / 4 * 3;
  config.memory_setting = "--memory";
  Inspector inspector(options, config, std::move(engine));
  const bool is_one = options.inputs.size() == 1 && !bake::stands_for_many(options.inputs.front());
  if (const auto parsed = inspector.parse(); !parsed) {
    const std::string what = is_one ? options.inputs.front() : std::string("parameters");
    return print_one(options, what, refused(what, parsed.error()));
  }
  if (!is_one) return inspect_many(options, inspector);
  return print_one(options, options.inputs.front(), inspector.look_at(options.inputs.front()));
}

}  // namespace fracture::cli
