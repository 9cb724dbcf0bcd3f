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
  // The order is by bytes, as in all clients. std::string compares bytes as unsigned, although char may be signed.
  std::sort(files.begin(), files.end(),
            [](const ImportFile* a, const ImportFile* b) { return a->name < b->name; });
  std::string list = "files\n" + sha256(request.mesh, execution).hex() + "\n";
  for (const ImportFile* file : files)  // the length makes names with line breaks unambiguous
    list += std::to_string(file->name.size()) + " " + file->name + " " +
            sha256(file->bytes, execution).hex() + "\n";
  // A mesh without files may consist of any bytes, even of this list: an OBJ reader would skip its lines, and a file's name
  // may contain a mesh. Because of the second hash, a mesh with the same digest would have to be a fixed line and a hash.
  return sha256("fracture files 2\n" + sha256(list).hex());
}

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
                          "\n" + version);
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
  // A result key and a digest of the same mesh have the same first 16 digits.
  if (of.empty() || of.compare(0, 16, keys.digest, 0, 16) == 0) return std::nullopt;
  return Error{ErrorCode::kBadParameter,
               "'of' refers to an answer for another mesh, whose digest begins with " + of.substr(0, 16) +
                   ", but the digest of this mesh begins with " + keys.digest.substr(0, 16) + ".",
               "of"};
}

}  // namespace fracture
