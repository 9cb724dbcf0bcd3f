#include "common/import/assimp_files.hpp"

#include <algorithm>
#include <cstring>

#include "common/import/uri.hpp"

namespace fracture {
namespace {

class MemoryStream : public Assimp::IOStream {
 public:
  explicit MemoryStream(std::span<const std::byte> bytes) : bytes_(bytes) {}

  std::size_t Read(void* to, std::size_t size, std::size_t count) override {
    if (size == 0) return 0;
    const std::size_t items = std::min(count, (bytes_.size() - at_) / size);
    if (items > 0) std::memcpy(to, bytes_.data() + at_, items * size);
    at_ += items * size;
    return items;
  }
  std::size_t Write(const void*, std::size_t, std::size_t) override { return 0; }
  aiReturn Seek(std::size_t offset, aiOrigin origin) override {
    const std::size_t base = origin == aiOrigin_CUR ? at_ : origin == aiOrigin_END ? bytes_.size() : 0;
    // From the end, Assimp counts backwards with a positive number (like its own MemoryIOStream).
    const std::size_t to = origin == aiOrigin_END ? base - std::min(offset, base) : base + offset;
    if (to > bytes_.size() || (origin != aiOrigin_END && to < base)) return aiReturn_FAILURE;
    at_ = to;
    return aiReturn_SUCCESS;
  }
  std::size_t Tell() const override { return at_; }
  std::size_t FileSize() const override { return bytes_.size(); }
  void Flush() override {}

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
};

}  // namespace

const std::span<const std::byte>* UploadedFiles::find(std::string_view name) const {
  if (name == main_name_) return &main_;
  if (const ImportFile* file = find_file(files_, name)) return &file->bytes;
  const std::string_view stem = std::string_view(main_name_).substr(0, main_name_.find_first_of("._"));
  name.remove_prefix(name.rfind('/') + 1);
  if (name.size() <= stem.size() + 1 || name.substr(0, stem.size()) != stem) return nullptr;
  const std::string_view ending = name.substr(stem.size());
  const ImportFile* companion = nullptr;
  for (const ImportFile& file : files_) {
    if (!std::string_view(file.name).ends_with(ending)) continue;
    if (companion != nullptr) return nullptr;
    companion = &file;
  }
  return companion != nullptr ? &companion->bytes : nullptr;
}

Assimp::IOStream* UploadedFiles::Open(const char* name, const char* mode) {
  const bool reading = mode != nullptr && std::strpbrk(mode, "wa+") == nullptr;
  const std::span<const std::byte>* bytes = reading ? find(name) : nullptr;
  return bytes != nullptr ? new MemoryStream(*bytes) : nullptr;
}

}  // namespace fracture
