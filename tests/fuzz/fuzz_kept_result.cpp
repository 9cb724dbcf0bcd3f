// Fuzz target: an intact entry from the disk or from Redis whose metadata may be forged. The input is the
// metadata without its digests (which are made right), then a NUL and the file. If the entry is accepted, its
// metadata can be written and read again, and a request may refer to it: with a hit, with nothing to compare,
// and with a density.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "common/digest/digest.hpp"
#include "common/parameters/parameter_object.hpp"
#include "server/service/earlier_answer.hpp"
#include "server/service/kept_result.hpp"

namespace {

using namespace fracture;

/// The digest of a part of the file, as in the metadata; the digest of nothing if the file has no such part.
std::string digest_of_part(const std::string& file, std::size_t at, std::size_t size) {
  const std::string part =
      at <= file.size() && size <= file.size() - at ? file.substr(at, size) : std::string();
  const Digest digest = sha256(part);
  return {reinterpret_cast<const char*>(digest.bytes.data()), digest.bytes.size()};
}

/// Refers to the earlier answer. Each result must be parameters or an error.
void name_it(const ParameterTable& table, const nlohmann::json& earlier, std::vector<RawParameter> given) {
  const auto own = table.parse(given);
  if (!own) std::abort();
  const auto all = on_earlier_answer(table, given, *own, earlier);
  if (!all) {
    if (all.error().detail.empty()) std::abort();
    return;
  }
  (void)table.parse(*all);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const ParameterTable table(100'000, FormatSet::all());
  const std::string input(reinterpret_cast<const char*>(data), size),
      key = std::string(16, 'a') + std::string(48, 'b');
  const std::size_t end = std::min(input.find('\0'), input.size());
  std::string metadata = input.substr(0, end);
  const std::string file = end < input.size() ? input.substr(end + 1) : "";
  std::size_t at = 0, length = 0, line = metadata.find('\n', metadata.find('\n') + 1);
  if (line != std::string::npos) std::sscanf(metadata.c_str() + line, "%zu %zu", &at, &length);
  metadata += digest_of_part(file, 0, file.size()) + digest_of_part(file, at, length);
  StoredEntry stored;
  stored.bytes.assign(file.begin(), file.end());
  stored.entry = {key, metadata, stored.bytes};
  const auto result = result_in(stored);
  if (!result) return 0;
  const std::string again = metadata_of(*result);
  StoredEntry rewritten;
  rewritten.bytes = result->file;
  rewritten.entry = {key, again, rewritten.bytes};
  if (!result_in(rewritten)) std::abort();
  const auto earlier = read_kept_parameters(result->parameters);
  if (!earlier) std::abort();
  const RawParameter of{"of", "/fractures/sha256:" + key, false};
  name_it(table, *earlier, {of, {"local_point", {0.5, 0.5, 0.5}, false}, {"local_radius", 0.2, false}});
  name_it(table, *earlier, {of, {"delta", "none", false}});
  name_it(table, *earlier, {of, {"density", 7.0, false}});
  return 0;
}
