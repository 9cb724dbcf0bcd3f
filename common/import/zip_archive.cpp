#include "common/import/zip_archive.hpp"

#include <zlib.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "common/base/printable.hpp"
#include "common/base/words.hpp"
#include "common/import/decompress.hpp"
#include "common/import/limit_words.hpp"

namespace fracture {
namespace {

// Lengths of the records without their variable parts (APPNOTE 4.3.7, 4.3.12, 4.3.14, 4.3.15, 4.3.16).
constexpr std::size_t kLocal = 30, kEntry = 46, kEnd64 = 56, kLocator = 20, kEnd = 22;

/// A field with all bits set is in the ZIP64 record or extra field instead.
constexpr std::uint64_t kIn64 = 0xffff'ffff;

std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::uint64_t number_at(std::string_view bytes, std::size_t at, std::size_t count) {
  std::uint64_t value = 0;
  for (std::size_t k = count; k-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[at + k]);
  return value;
}

/// Whether `count` bytes from `at` are before `end`.
bool is_before(std::uint64_t at, std::uint64_t count, std::uint64_t end) {
  return at <= end && count <= end - at;
}

struct Directory {
  std::uint64_t entries = 0, at = 0, end = 0;
};

std::optional<Directory> find_directory(std::string_view text) {
  // The end record has a comment of at most 65,535 bytes.
  const std::size_t tail = text.size() - std::min<std::size_t>(text.size(), kEnd + 65'535);
  const std::size_t end = text.rfind("PK\x05\x06");
  if (text.substr(0, 2) != "PK" || end == std::string_view::npos || end < tail || end + kEnd > text.size())
    return std::nullopt;
  Directory directory{number_at(text, end + 10, 2), number_at(text, end + 16, 4), end};
  const bool is_64 =
      directory.entries == 0xffff || directory.at == kIn64 || number_at(text, end + 12, 4) == kIn64;
  if (!is_64 || end < kLocator || text.substr(end - kLocator, 4) != "PK\x06\x07") return directory;
  const std::uint64_t end64 = number_at(text, end - kLocator + 8, 8);
  if (!is_before(end64, kEnd64, end) || text.substr(end64, 4) != "PK\x06\x06") return std::nullopt;
  return Directory{number_at(text, end64 + 32, 8), number_at(text, end64 + 48, 8), end64};
}

/// Replaces the fields of an entry that are in its ZIP64 extra field (APPNOTE 4.5.3). Returns false if they are missing.
bool read_extra(std::string_view extra, ZipEntry& entry) {
  std::uint64_t* const wanted[] = {&entry.size, &entry.packed, &entry.header};
  if (std::none_of(std::begin(wanted), std::end(wanted), [](const auto* field) { return *field == kIn64; }))
    return true;
  while (extra.size() >= 4) {
    const std::uint64_t length = number_at(extra, 2, 2);
    if (length > extra.size() - 4) return false;
    if (number_at(extra, 0, 2) != 1) {
      extra.remove_prefix(4 + length);
      continue;
    }
    std::string_view fields = extra.substr(4, length);
    for (std::uint64_t* const field : wanted) {
      if (*field != kIn64) continue;
      if (fields.size() < 8) return false;
      *field = number_at(fields, 0, 8);
      fields.remove_prefix(8);
    }
    return true;
  }
  return false;
}

std::string quoted(std::string_view name) { return "\"" + shortened(printable(name)) + "\""; }

}  // namespace

Expected<std::vector<ZipEntry>> read_zip_directory(std::span<const std::byte> archive,
                                                   std::uint64_t max_bytes) {
  const std::string_view text = as_text(archive);
  const std::optional<Directory> directory = find_directory(text);
  if (!directory)
    return fail(
        ErrorCode::kMalformedMesh,
        "This format requires a complete ZIP archive, which begins with \"PK\" and ends with its directory. "
        "The file is not one. Copy, download or export the file again.");
  std::vector<ZipEntry> entries;
  std::uint64_t at = directory->at, decoded = 0;
  for (std::uint64_t k = 0; k < directory->entries; ++k) {
    ZipEntry entry;
    const bool has_head = is_before(at, kEntry, directory->end) && text.substr(at, 4) == "PK\x01\x02";
    const std::uint64_t name = has_head ? number_at(text, at + 28, 2) : 0,
                        extra = has_head ? number_at(text, at + 30, 2) : 0,
                        comment = has_head ? number_at(text, at + 32, 2) : 0;
    bool complete = has_head && is_before(at + kEntry, name + extra + comment, directory->end);
    if (complete) {
      entry.flags = static_cast<std::uint16_t>(number_at(text, at + 8, 2));
      entry.method = static_cast<std::uint16_t>(number_at(text, at + 10, 2));
      entry.crc = static_cast<std::uint32_t>(number_at(text, at + 16, 4));
      entry.packed = number_at(text, at + 20, 4);
      entry.size = number_at(text, at + 24, 4);
      entry.header = number_at(text, at + 42, 4);
      entry.name = text.substr(at + kEntry, name);
      complete = read_extra(text.substr(at + kEntry + name, extra), entry);
    }
    if (!complete)
      return fail(ErrorCode::kMalformedMesh,
                  "Entry " + std::to_string(k + 1) + " of " + std::to_string(directory->entries) +
                      " in the ZIP directory, at byte " + std::to_string(at) + ", is incomplete.");
    if (entry.size > max_bytes || decoded > max_bytes - entry.size)
      return fail(ErrorCode::kTooLarge,
                  "The content of the ZIP archive exceeds the limit of " + decoded_limit(max_bytes) +
                      ": its entry " + std::to_string(k + 1) + ", " + quoted(entry.name) + ", has " +
                      data_size(entry.size) + ". " + kSmallerMesh,
                  {}, {{"limit", max_bytes}});
    decoded += entry.size;
    at += kEntry + name + extra + comment;
    entries.push_back(entry);
  }
  return entries;
}

Expected<std::vector<std::byte>> unzip(std::span<const std::byte> archive, const ZipEntry& entry,
                                       std::uint64_t max_bytes) {
  const std::string_view text = as_text(archive);
  const auto damaged = [&](const std::string& why) {
    return fail(ErrorCode::kMalformedMesh,
                "The file " + quoted(entry.name) + " in the ZIP archive is damaged: " + why);
  };
  if ((entry.flags & 1) != 0)
    return fail(ErrorCode::kUnsupportedFeature,
                "The file " + quoted(entry.name) +
                    " in the ZIP archive is encrypted. Save the archive without a password.");
  if (entry.size > max_bytes)
    return fail(ErrorCode::kTooLarge,
                "The file " + quoted(entry.name) + " in the ZIP archive has " + data_size(entry.size) +
                    "; the limit is " + decoded_limit(max_bytes) + ". " + kSmallerMesh,
                {}, {{"limit", max_bytes}});
  if (!is_before(entry.header, kLocal, text.size()) || text.substr(entry.header, 4) != "PK\x03\x04")
    return damaged("its header should be at byte " + std::to_string(entry.header) +
                   ", but other data are there.");
  const std::uint64_t begin =
      entry.header + kLocal + number_at(text, entry.header + 26, 2) + number_at(text, entry.header + 28, 2);
  if (!is_before(begin, entry.packed, text.size())) return damaged("the archive ends before its data.");
  const std::span<const std::byte> packed = archive.subspan(begin, entry.packed);
  constexpr std::uint16_t kStored = 0, kDeflated = 8;
  std::vector<std::byte> bytes;
  if (entry.method == kStored) {
    bytes.assign(packed.begin(), packed.end());
  } else if (entry.method == kDeflated) {
    Expected<std::vector<std::byte>> inflated = inflate_raw(packed, entry.size);
    if (!inflated) return damaged(inflated.error().detail);
    bytes = std::move(*inflated);
  } else {
    return fail(ErrorCode::kUnsupportedFeature,
                "The file " + quoted(entry.name) + " in the ZIP archive has the compression method " +
                    std::to_string(entry.method) + ". Only stored (0) and deflated (8) files are supported.");
  }
  if (bytes.size() != entry.size)
    return damaged("it has " + std::to_string(bytes.size()) + " bytes instead of " +
                   std::to_string(entry.size) + ".");
  uLong crc = crc32(0, nullptr, 0);
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t some = std::min<std::size_t>(bytes.size() - at, std::numeric_limits<uInt>::max());
    crc = crc32(crc, reinterpret_cast<const Bytef*>(bytes.data() + at), static_cast<uInt>(some));
    at += some;
  }
  if (static_cast<std::uint32_t>(crc) != entry.crc) return damaged("its checksum does not match.");
  return bytes;
}

}  // namespace fracture
