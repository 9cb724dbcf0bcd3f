#include "common/import/gltf_entries.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

namespace fracture {
namespace {

using nlohmann::json;

/// Stores no values. Even for text that consists only of brackets, the parser keeps only one bit per bracket.
class Reader final : public nlohmann::json_sax<json> {
 public:
  using Take = std::function<bool(const std::string&, std::string&)>;
  Reader(const char* member, const Take& take) : member_(member), take_(take) {}

  bool null() override { return value(); }
  bool boolean(bool) override { return value(); }
  bool number_integer(number_integer_t) override { return value(); }
  bool number_unsigned(number_unsigned_t) override { return value(); }
  bool number_float(number_float_t, const string_t&) override { return value(); }
  bool binary(binary_t&) override { return false; }
  bool string(string_t& text) override {
    const bool wanted = depth_ == kEntry && in_entry_ && named_;
    value();
    return !wanted || take_(list_, text);
  }
  bool start_object(std::size_t) override {
    if (depth_ == 0) in_document_ = true;
    if (depth_ == kEntry - 1) in_entry_ = in_list_;
    return open();
  }
  bool start_array(std::size_t) override {
    if (depth_ == 1) in_list_ = in_document_;
    if (depth_ == kEntry - 1) in_entry_ = false;
    return open();
  }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(string_t& name) override {
    if (depth_ == 1) list_ = name;
    if (depth_ == kEntry) named_ = name == member_;
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception&) override {
    return false;
  }

 private:
  static constexpr std::size_t kEntry = 3;  // the document, a list in it, and an object in the list
  bool value() {
    if (depth_ == kEntry) named_ = false;
    return true;
  }
  bool open() {
    value();
    ++depth_;
    return true;
  }
  bool close() {
    --depth_;
    if (depth_ == 1) in_list_ = false;
    return true;
  }

  const std::string_view member_;
  const Take& take_;
  std::string list_;
  std::size_t depth_ = 0;
  bool in_document_ = false, in_list_ = false, in_entry_ = false, named_ = false;
};

}  // namespace

std::string_view gltf_text(std::string_view bytes) {
  constexpr std::size_t kText = 20;
  if (!bytes.starts_with("glTF") || bytes.size() < kText) return bytes;
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 12, sizeof length);
  return bytes.substr(kText, length);
}

bool read_gltf_entries(std::string_view bytes, const char* member,
                       const std::function<bool(const std::string& list, std::string& text)>& take) {
  const std::string_view text = gltf_text(bytes);
  Reader reader(member, take);
  return json::sax_parse(text.begin(), text.end(), &reader);
}

}  // namespace fracture
