#include "server/jobs/job_record.hpp"

#include <algorithm>
#include <charconv>
#include <utility>

#include "common/digest/digest.hpp"

namespace fracture {
namespace {

using nlohmann::json;

constexpr std::string_view kRecord = "fracture job 1\n", kMesh = "fracture mesh 1\n";
constexpr std::size_t kHex = 64;
/// More than any request may have.
constexpr std::uint64_t kMostFiles = 1u << 16;

bool is_hex(std::string_view text) {
  return std::all_of(text.begin(), text.end(),
                     [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

std::chrono::sys_time<std::chrono::microseconds> time_of(const json& microseconds) {
  return std::chrono::sys_time<std::chrono::microseconds>(
      std::chrono::microseconds(microseconds.get<std::int64_t>()));
}

JobRecord record_of(const json& j) {
  JobRecord r;
  r.id = j.at("id").get<std::string>();
  r.owner = j.at("owner").get<std::string>();
  r.state = job_state_named(j.at("state").get<std::string>()).value();
  r.created = time_of(j.at("created"));
  if (j.contains("finished")) r.finished_at = time_of(j.at("finished"));
  r.patience = std::chrono::milliseconds(j.at("patience_ms").get<std::int64_t>());
  r.digest = j.at("digest").get<std::string>();
  r.mesh_bytes = j.at("mesh_bytes").get<std::uint64_t>();
  r.format = format_from_extension(j.at("format").get<std::string>()).value();
  r.output = j.at("output").get<std::string>() == "gltf" ? OutputFormat::kGltf : OutputFormat::kGlb;
  r.triangles = j.at("triangles").get<std::uint64_t>();
  r.parameters = j.at("parameters");
  r.result_key = j.at("result").get<std::string>();
  if (j.contains("error")) {
    const json& e = j.at("error");
    r.error = Error{error_code(e.at("code").get<std::string>()).value(), e.at("detail").get<std::string>(),
                    e.at("pointer").get<std::string>(), Figures(e.at("extra"))};
  }
  return r;
}

/// Reads numbers and texts off the front of bytes; false, for good, where they are not there.
class Reader {
 public:
  Reader(const std::vector<std::uint8_t>& bytes, std::size_t at) : bytes_(bytes), at_(at) {}
  bool literal(std::string_view text) {
    const auto found = take(text.size());
    return found && *found == text;
  }
  /// In decimal digits, and the character behind them.
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
  if (r.finished_at) j["finished"] = r.finished_at->time_since_epoch().count();
  if (r.error)
    j["error"] = {{"code", slug(r.error->code)},
                  {"detail", r.error->detail},
                  {"pointer", r.error->pointer},
                  {"extra", *r.error->extra}};
  // Throws for what is no UTF-8, which would be read back as something else: such a job is refused (Room::kUnfit).
  const std::string text = j.dump() + "\n";
  return std::string(kRecord) + sha256(text).hex() + "\n" + text;
}

std::optional<JobRecord> decode_record(std::string_view bytes) {
  if (!bytes.starts_with(kRecord)) return std::nullopt;
  bytes.remove_prefix(kRecord.size());
  if (bytes.size() < kHex + 1 || bytes[kHex] != '\n') return std::nullopt;
  const std::string_view digest = bytes.substr(0, kHex), text = bytes.substr(kHex + 1);
  if (sha256(text).hex() != digest) return std::nullopt;
  try {
    JobRecord record = record_of(json::parse(text));
    if (!is_job_id(record.id) || record.digest.size() != kHex || !is_hex(record.digest) ||
        !record.parameters.is_object() || record.patience.count() <= 0)
      return std::nullopt;
    return record;
  } catch (const std::exception&) {  // of another version: the sum is right, the members are not
    return std::nullopt;
  }
}

std::string encode_mesh_head(const FractureRequest& request) {
  std::string head = std::string(kMesh) + std::to_string(request.mesh.size()) + " " +
                     std::to_string(request.files.size()) + "\n";
  for (const ImportFile& file : request.files)  // the length keeps names with line breaks apart
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
