#include "server/service/request.hpp"

#include <algorithm>
#include <string_view>

#include "common/pipeline/algorithm_version.hpp"

namespace fracture {
namespace {

std::string hex_of(std::string_view material) { return sha256(material).hex(); }

}  // namespace

Digest digest_of(const FractureRequest& request, const Execution& execution) {
  if (request.files.empty()) return sha256(request.mesh, execution);
  std::vector<const ImportFile*> files;
  for (const ImportFile& file : request.files) files.push_back(&file);
  // By bytes, as every client sorts them; a char of itself is signed on some machines.
  std::sort(files.begin(), files.end(),
            [](const ImportFile* a, const ImportFile* b) { return a->name < b->name; });
  std::string list = "files\n" + sha256(request.mesh, execution).hex() + "\n";
  for (const ImportFile* file : files)  // the length keeps names with line breaks apart
    list += std::to_string(file->name.size()) + " " + file->name + " " +
            sha256(file->bytes, execution).hex() + "\n";
  // A mesh alone may have any bytes, those of this list too: an OBJ of lines that its reader skips, with a
  // mesh in the name of a file. Hashed twice, what would have to be such a mesh is one fixed line and a hash.
  return sha256("fracture files 2\n" + sha256(list).hex());
}

namespace {

/// Where there are hits, make_diagram() grows aggregates, which are no smaller than the limits of size say.
std::string sizes_in_diagram(const FractureParameters& parameters) {
  if (parameters.hits.empty() || cells_per_fragment(parameters) == 1) return {};
  const SizeLimits& size = parameters.size;
  return nlohmann::json{size.min_volume, size.min_fraction, size.min_of_mean}.dump() + "\n";
}

}  // namespace

RequestKeys keys_of(const FractureRequest& request) {
  if (request.keys) return *request.keys;
  const RequestParameters& parameters = request.parameters;
  const std::string version = std::to_string(kAlgorithmVersion);
  RequestKeys keys;
  keys.digest = request.digest.empty() ? digest_of(request).hex() : request.digest;
  keys.mesh =
      keys.digest + "." + extension_of(request.format) + "\n" + canonical_solid_parameters(parameters).dump();
  const auto fractured = [&](bool hit) {
    return hex_of("fractured\n" + keys.mesh + "\n" + canonical_base_parameters(parameters, hit).dump() +
                  "\n" + version);
  };
  if (parameters.selection.new_hits) {
    keys.diagram = fractured(false);
  } else {
    keys.diagram = hex_of("diagram\n" + keys.mesh + "\n" + canonical_site_parameters(parameters).dump() +
                          "\n" + sizes_in_diagram(parameters.fracture) + version);
  }
  if (parameters.selection.kept) keys.kept = fractured(true);
  keys.result = keys.digest.substr(0, 16) +
                hex_of("result\n" + keys.mesh + "\n" + canonical_parameters(parameters).dump() + "\n" +
                       version + (request.output == OutputFormat::kGltf ? "\ngltf" : "\nglb"))
                    .substr(0, 48);
  return keys;
}

std::optional<Error> wrong_mesh(const FractureRequest& request, const RequestKeys& keys) {
  const std::string& of = request.parameters.of;
  // Both begin with the digest of their mesh.
  if (of.empty() || of.compare(0, 16, keys.digest, 0, 16) == 0) return std::nullopt;
  return Error{ErrorCode::kBadParameter,
               "'of' refers to an answer for another mesh, whose digest begins with " + of.substr(0, 16) +
                   ", but the digest of this mesh begins with " + keys.digest.substr(0, 16) + ".",
               "of"};
}

}  // namespace fracture
