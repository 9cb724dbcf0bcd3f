#include "server/http/mesh_input.hpp"

#include <algorithm>
#include <utility>

#include "common/base/words.hpp"
#include "common/parameters/parameter_object.hpp"
#include "server/http/api.hpp"
#include "server/http/multipart.hpp"

namespace fracture::http {
namespace {

constexpr std::size_t kMaxField = 16u << 10;  // maximum bytes of a parameter in its own form field

/// Normalizes a filename as assets write it: forward slashes, no leading "./".
std::string file_name(std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  while (name.substr(0, 2) == "./") name.erase(0, 2);
  return name;
}

}  // namespace

std::vector<RawParameter> raw_parameters(const std::vector<std::pair<std::string, std::string>>& query) {
  std::vector<RawParameter> given;
  given.reserve(query.size());
  for (const auto& [name, value] : query) given.push_back({name, value, true});
  return given;
}

Problem unknown_format(const FormatSet& formats, std::string_view given) {
  std::string names;
  for (const std::string& name : formats.names()) names += (names.empty() ? "" : ", ") + name;
  std::string detail = "The request does not specify the format of the mesh.";
  if (!given.empty())
    detail = std::string(given).insert(0, 1, '\'') + "' is not a mesh format that this server reads.";
  return to_problem(
      {ErrorCode::kUnknownFormat,
       detail +
           " Give a supported format in Content-Type (for example model/gltf-binary), or as ?format= with one of " +
           names + ".",
       "format"});
}

OrProblem<FractureRequest> read_mesh_input(const Request& request, std::shared_ptr<const Body> body,
                                           FractureService& service, const Execution& execution,
                                           const FractureService::MaySee& may_see) {
  std::vector<RawParameter> given = raw_parameters(request.admission.query);
  const std::string content_type = request.head.field("content-type");
  std::string_view mesh = body->bytes;
  std::string declared_type = media_type_of(content_type);
  std::string extension;
  std::vector<ImportFile> files;

  if (const auto boundary = multipart_boundary(content_type)) {
    auto parts = parse_multipart(body->bytes, *boundary, execution);
    if (!parts) return tl::unexpected<Problem>(std::move(parts.error()));
    bool found = false;
    for (const FormPart& part : *parts) {
      if (part.name == "mesh") {
        if (found)
          return refuse(HttpProblem::kMalformedMultipart, "The part 'mesh' was given more than once.");
        found = true;
        mesh = part.body;
        declared_type = part.content_type;
        if (part.filename) extension = part.filename->substr(part.filename->rfind('.') + 1);
      } else if (part.name == "params") {
        Expected<std::vector<RawParameter>> params = read_parameters(part.body, "part 'params'");
        if (!params) return tl::unexpected<Problem>(to_problem(std::move(params.error())));
        given.insert(given.end(), params->begin(), params->end());
      } else if (part.filename) {
        const std::string name = file_name(*part.filename);
        if (name.empty())
          return refuse(HttpProblem::kMalformedMultipart, "A file part has an empty filename.");
        if (std::any_of(files.begin(), files.end(), [&](const ImportFile& f) { return f.name == name; }))
          return refuse(
              HttpProblem::kMalformedMultipart,
              "Two file parts have the same filename. Give each file the unique name by which the mesh refers to it.");
        files.push_back({name, std::as_bytes(std::span(part.body.data(), part.body.size()))});
      } else if (part.body.size() > kMaxField) {
        return refuse(
            HttpProblem::kMalformedMultipart,
            "A form field without a filename has more than " + grouped(kMaxField) +
                " bytes, which is the limit. If it is a file, give it a filename. Send long parameters as JSON in the part 'params'.");
      } else {
        given.push_back({part.name, std::string(part.body), true});  // one parameter: sites=50
      }
    }
    if (!found)
      return tl::unexpected<Problem>(
          to_problem({ErrorCode::kEmptyBody,
                      "The form has no part named 'mesh'. Send the mesh file as the part 'mesh'.", "mesh"}));
  }

  const ParameterTable& table = service.parameters();
  Expected<RequestParameters> parameters = service.parse(given, may_see);
  if (!parameters) return tl::unexpected<Problem>(to_problem(std::move(parameters.error())));
  std::optional<MeshFormat> format = parameters->format;
  if (!format) format = format_from_media_type(declared_type);
  if (!format) format = format_from_extension(extension);
  if (!format) format = format_from_content(std::as_bytes(std::span(mesh.data(), mesh.size())));
  if (!format || !table.formats().contains(*format))
    return tl::unexpected<Problem>(
        unknown_format(table.formats(), extension.empty() ? declared_type : extension));

  FractureRequest asked{std::as_bytes(std::span(mesh.data(), mesh.size())), *format, std::move(*parameters),
                        std::move(files)};
  asked.owner = std::move(body);
  return asked;
}

}  // namespace fracture::http
