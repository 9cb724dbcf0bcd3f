// fracture-server inspect: reports what the service would make of a mesh, without fracturing it.
#include <cerrno>
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "common/base/printable.hpp"
#include "common/base/words.hpp"
#include "common/contacts/contact_report.hpp"
#include "common/gltf/report_text.hpp"
#include "common/mesh/dropped.hpp"
#include "common/mesh/material_library.hpp"
#include "common/pipeline/overlaps.hpp"
#include "server/bake/failure.hpp"
#include "server/bake/import_workers.hpp"
#include "server/bake/input_file.hpp"
#include "server/cli/options.hpp"
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

ForRequest for_request(const PreparedMesh& mesh, const FractureRequest& request, std::uint64_t limit) {
  ForRequest result;
  check_size_of_pieces(mesh, request, result.remarks, result.choices);
  result.estimate = estimate_document(request.parameters, mesh.solid, limit);
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

void print(const std::string& input, const PreparedMesh& mesh, const ForRequest& asked, bool mended) {
  const SolidReport& r = mesh.solid.report;
  const Mesh& source = *mesh.solid.source;
  std::printf("%s: %s\n", input.c_str(), mended ? "usable after repair" : "a closed solid as it is");
  const Vec3d size = mesh.solid.box.size();
  std::printf("  size       %.6g x %.6g x %.6g m (one unit is %.9g m: %s; %s up: %s)\n", size.x, size.y,
              size.z, mesh.frame.metres_per_unit, name_of(mesh.frame.unit_from), mesh.frame.z_up ? "z" : "y",
              name_of(mesh.frame.up_from));
  std::printf("  volume     %.9g m³ (%.9g m³ with overlaps counted once), area %.9g m²\n", r.volume,
              volume_once(mesh.solid, {}), r.area);
  const auto nodes = source.node_names.size(), materials = source.library->materials.size(),
             images = source.library->images.size();
  std::printf("  solid      %s, %s, %s\n", counted(r.parts, "part", "parts").c_str(),
              counted(r.shells, "shell", "shells").c_str(),
              counted(r.cavities, "cavity", "cavities").c_str());
  if (const auto contacts = contact_report(mesh.solid))
    std::printf("  contacts   %s of parts are in contact, %" PRIu64
                " of these pairs overlap: area %.6g m², common volume %.6g m³; %s no other part\n",
                counted(contacts->pairs, "pair", "pairs").c_str(), contacts->overlapping, contacts->area,
                contacts->volume, counted(contacts->alone, "part touches", "parts touch").c_str());
  std::printf(
      "  source     %s, %s, %s, %s, %s\n", counted(r.source_triangles, "triangle", "triangles").c_str(),
      counted(r.source_vertices, "vertex", "vertices").c_str(), counted(nodes, "node", "nodes").c_str(),
      counted(materials, "material", "materials").c_str(), counted(images, "image", "images").c_str());
  if (source.passed_through)
    std::printf("  not fractured: %s\n",
                counted(source.passed_through->triangles.size(), "triangle", "triangles").c_str());
  if (mended)
    std::printf("  repaired   %s, %s, %s; %.6g m² were added\n",
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

int refuse(const InspectOptions& options, const Error& error) {
  if (options.json) {
    const nlohmann::json report = {{"verdict", "refused"},
                                   {"error", slug(error.code)},
                                   {"detail", error.detail},
                                   {"pointer", error.pointer},
                                   {"figures", *error.extra}};
    std::printf("%s\n", report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
  } else {
    std::printf("%s: refused: %s\n", options.input.c_str(), printable_lines(bake::to_lines(error)).c_str());
  }
  return exit_code(error.code);
}

}  // namespace

int inspect(const InspectOptions& options) {
  std::unique_ptr<FractureEngine> engine;
  try {
    engine = make_engine(bake::own_import_workers(1));
  } catch (const std::runtime_error& e) {
    std::fprintf(stderr, "fracture-server inspect: %s\n", e.what());
    return kExitSystem;
  }
  FractureService service(options.service, std::move(engine));
  Expected<RequestParameters> parameters = service.parameters().parse(options.parameters);
  if (!parameters) return refuse(options, parameters.error());
  std::optional<std::string> bytes = bake::read_bytes(options.input);
  if (!bytes) {
    std::fprintf(stderr, "fracture-server inspect: cannot read %s: %s\n", options.input.c_str(),
                 std::strerror(errno));
    return kExitSystem;
  }
  const Expected<bake::InputFile> input = bake::to_input(options.input, std::move(*bytes), *parameters);
  if (!input) return refuse(options, input.error());
  Execution execution;
  execution.threads = options.threads > 0 ? options.threads : available_cores();
  const FractureRequest request{input->view(), input->format, *parameters, as_import_files(input->siblings)};
  const auto mesh = service.prepare(request, execution);
  if (!mesh) return refuse(options, mesh.error());
  const bool mended = repaired((*mesh)->solid.report);
  const ForRequest asked = for_request(**mesh, request, options.service.max_bytes_per_job);
  if (options.json) {
    nlohmann::json report = mesh_report(**mesh);
    report["estimate"] = asked.estimate;
    for (const std::string& warning : asked.remarks.warnings) report["warnings"].push_back(warning);
    for (const nlohmann::json& choice : choices_document(asked.choices)) report["choices"].push_back(choice);
    std::printf("%s\n", report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
  } else {
    print(options.input, **mesh, asked, mended);
  }
  return mended ? kExitRepaired : kExitDone;
}

}  // namespace fracture::cli
