#include "server/jobs/job_record.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "common/base/json_reader.hpp"
#include "common/digest/digest.hpp"
#include "common/parameters/parameter_object.hpp"

namespace fracture {
namespace {

using nlohmann::json;

constexpr std::string_view kRecord = "fracture job 1\n", kMesh = "fracture mesh 1\n";
constexpr std::size_t kHex = 64;
/// More files than any request may have.
constexpr std::uint64_t kMostFiles = 1u << 16;

bool is_hex(std::string_view text) {
  return std::all_of(text.begin(), text.end(),
                     [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

// A record is parsed as strictly as a request, with limits, because anyone with write access to the folder
// can create one with a valid checksum.

/// One level deeper than the parameters (kParameterDepth), because the record contains them. Error data is
/// not deeper.
constexpr JsonLimits kLimits{.depth = kParameterDepth + 1, .bytes = kOfKept.held};
/// The end of the year 9999, the last time that the text format can represent.
constexpr std::int64_t kLastTime = 253'402'300'799'999'999;
/// One day in milliseconds, the longest deadline that can be set.
constexpr std::int64_t kMostPatience = 86'400'000;
/// The largest value of --max-body.
constexpr std::uint64_t kMostMeshBytes = 1ull << 40;
/// A name in a token file has at most 64 bytes, and a client's key a few more; the detail of an error has a few
/// sentences.
constexpr std::size_t kMostOwner = 1024, kMostDetail = 64u << 10;

/// Thrown for input that encode_record() never writes.
struct Unlikely {};

void require(bool likely) {
  if (!likely) throw Unlikely();
}

/// Reads a whole number in a range.
template <class Number>
Number number_at(const json& object, const char* name, Number least, Number most) {
  const json& value = object.at(name);
  require(value.is_number_integer());
  // A number above 2^63 would become negative.
  require(std::is_unsigned_v<Number> ? value.is_number_unsigned()
                                     : !value.is_number_unsigned() ||
                                           value.get<std::uint64_t>() <= static_cast<std::uint64_t>(most));
  const auto number = value.get<Number>();
  require(number >= least && number <= most);
  return number;
}

std::string text_at(const json& object, const char* name, std::size_t most) {
  const auto& text = object.at(name).get_ref<const std::string&>();
  require(text.size() <= most);
  return text;
}

std::string digits_at(const json& object, const char* name) {
  std::string digits = text_at(object, name, kHex);
  require(digits.size() == kHex && is_hex(digits));
  return digits;
}

std::chrono::sys_time<std::chrono::microseconds> time_at(const json& object, const char* name) {
  return std::chrono::sys_time<std::chrono::microseconds>(
      std::chrono::microseconds(number_at<std::int64_t>(object, name, 0, kLastTime)));
}

JobRecord record_of(const json& j) {
  JobRecord r;
  r.id = text_at(j, "id", kMostOwner);
  require(is_job_id(r.id));
  r.owner = text_at(j, "owner", kMostOwner);
  if (j.contains("client")) {
    r.client = text_at(j, "client", kMostOwner);
    require(!r.client.empty());
  }
  const auto state = job_state_named(text_at(j, "state", kHex));
  require(state.has_value());
  r.state = *state;
  r.created = time_at(j, "created");
  if (j.contains("finished")) r.finished_at = time_at(j, "finished");
  r.patience = std::chrono::milliseconds(number_at<std::int64_t>(j, "patience_ms", 1, kMostPatience));
  r.digest = digits_at(j, "digest");
  r.mesh_bytes = number_at<std::uint64_t>(j, "mesh_bytes", 0, kMostMeshBytes);
  const auto format = format_from_extension(text_at(j, "format", kHex));
  require(format.has_value());
  r.format = *format;
  const std::string output = text_at(j, "output", kHex);
  require(output == "gltf" || output == "glb");
  r.output = output == "gltf" ? OutputFormat::kGltf : OutputFormat::kGlb;
  r.triangles = number_at<std::uint64_t>(j, "triangles", 0, UINT32_MAX);
  r.parameters = j.at("parameters");
  require(are_parameters(r.parameters));
  r.result_key = digits_at(j, "result");
  if (j.contains("error")) {
    const json& e = j.at("error");
    const auto code = error_code(text_at(e, "code", kHex));
    require(code.has_value() && e.at("extra").is_object());
    r.error = Error{*code, text_at(e, "detail", kMostDetail), text_at(e, "pointer", kMostDetail),
                    Figures(e.at("extra"))};
  }
  return r;
}

/// Reads numbers and texts from the front of the bytes. After the first mismatch, all reads fail.
class Reader {
 public:
  Reader(const std::vector<std::uint8_t>& bytes, std::size_t at) : bytes_(bytes), at_(at) {}
  bool literal(std::string_view text) {
    const auto found = take(text.size());
    return found && *found == text;
  }
  /// Reads decimal digits and the character after them.
  std::optional<std::uint64_t> number(char end) {
    const char* const first = text() + at_;
    std::uint64_t value = 0;
    const auto [last, error] = std::from_chars(first, text() + bytes_.size(), value);
    if (error != std::errc{} || last == text() + bytes_.size() || *last != end) return std::nullopt;
    at_ += static_cast<std::size_t>(last - first) + 1;
    return value;
  }
  std::optional<std::string_view> take(std::uint64_t size) {
    if (size > bytes_.size() - at_) return std::nullopt;
    const std::string_view taken(text() + at_, static_cast<std::size_t>(size));
    at_ += taken.size();
    return taken;
  }
  bool at_end() const { return at_ == bytes_.size(); }

 private:
  const char* text() const { return reinterpret_cast<const char*>(bytes_.data()); }
  const std::vector<std::uint8_t>& bytes_;
  std::size_t at_;
};

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

}  // namespace

bool is_job_id(std::string_view id) {
  return id.size() == 33 && id[16] == '-' && is_hex(id.substr(0, 16)) && is_hex(id.substr(17));
}

std::string encode_record(const JobRecord& r) {
  json j = {{"id", r.id},
            {"owner", r.owner},
            {"state", name_of(r.state)},
            {"created", r.created.time_since_epoch().count()},
            {"patience_ms", r.patience.count()},
            {"digest", r.digest},
            {"mesh_bytes", r.mesh_bytes},
            {"format", extension_of(r.format)},
            {"output", r.output == OutputFormat::kGltf ? "gltf" : "glb"},
            {"triangles", r.triangles},
            {"parameters", r.parameters},
            {"result", r.result_key}};
  if (!r.client.empty()) j["client"] = r.client;
  if (r.finished_at) j["finished"] = r.finished_at->time_since_epoch().count();
  if (r.error)
    j["error"] = {{"code", slug(r.error->code)},
                  {"detail", r.error->detail},
                  {"pointer", r.error->pointer},
                  {"extra", *r.error->extra}};
  // Throws if a text is not UTF-8, because it would not be read back unchanged. Such a job is refused
  // (Room::kUnfit).
  const std::string text = j.dump() + "\n";
  return std::string(kRecord) + sha256(text).hex() + "\n" + text;
}

std::optional<JobRecord> decode_record(std::string_view bytes) {
  if (!bytes.starts_with(kRecord)) return std::nullopt;
  bytes.remove_prefix(kRecord.size());
  if (bytes.size() < kHex + 1 || bytes[kHex] != '\n') return std::nullopt;
  const std::string_view digest = bytes.substr(0, kHex), text = bytes.substr(kHex + 1);
  if (sha256(text).hex() != digest) return std::nullopt;
  const auto read = read_json(text, kLimits);
  if (!read) return std::nullopt;
  try {
    return record_of(read->value);
  } catch (const Unlikely&) {
  } catch (const json::exception&) {  // a member is missing or has another type
  }
  return std::nullopt;
}

std::string encode_mesh_head(const FractureRequest& request) {
  std::string head = std::string(kMesh) + std::to_string(request.mesh.size()) + " " +
                     std::to_string(request.files.size()) + "\n";
  for (const ImportFile& file : request.files)  // the length allows names with line breaks
    head += std::to_string(file.name.size()) + " " + std::to_string(file.bytes.size()) + " " + file.name;
  return head;
}

std::optional<KeptMesh> decode_mesh(std::shared_ptr<const std::vector<std::uint8_t>> bytes, std::size_t at,
                                    std::string_view digest) {
  if (!bytes || at > bytes->size()) return std::nullopt;
  Reader reader(*bytes, at);
  if (!reader.literal(kMesh)) return std::nullopt;
  const auto size = reader.number(' ');
  const auto count = size ? reader.number('\n') : std::nullopt;
  if (!count || *count > kMostFiles) return std::nullopt;
  FractureRequest request;
  std::vector<std::uint64_t> sizes;
  for (std::uint64_t k = 0; k < *count; ++k) {
    const auto name_size = reader.number(' ');
    const auto file_size = name_size ? reader.number(' ') : std::nullopt;
    const auto name = file_size ? reader.take(*name_size) : std::nullopt;
    if (!name) return std::nullopt;
    request.files.push_back({std::string(*name), {}});
    sizes.push_back(*file_size);
  }
  const auto mesh = reader.take(*size);
  if (!mesh) return std::nullopt;
  request.mesh = bytes_of(*mesh);
  for (std::size_t k = 0; k < sizes.size(); ++k) {
    const auto file = reader.take(sizes[k]);
    if (!file) return std::nullopt;
    request.files[k].bytes = bytes_of(*file);
  }
  if (!reader.at_end() || digest_of(request).hex() != digest) return std::nullopt;
  return KeptMesh{std::move(bytes), request.mesh, std::move(request.files)};
}

}  // namespace fracture
