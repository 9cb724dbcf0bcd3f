#include "common/base/json_reader.hpp"

#include <algorithm>
#include <utility>

#include "common/base/bulk.hpp"
#include "common/base/pacer.hpp"
#include "common/base/words.hpp"

namespace fracture {
namespace {

using nlohmann::json;

/// Bytes that malloc uses for an allocation: one extra word, rounded up to a multiple of 16, at least 32
/// (glibc, malloc.c).
constexpr std::size_t allocated(std::size_t bytes) {
  return bytes == 0 ? 0 : std::max<std::size_t>(32, (bytes + 8 + 15) / 16 * 16);
}

// A node of std::map: three pointers and a colour before the pair.
constexpr std::size_t kMember = allocated(4 * sizeof(void*) + sizeof(json::object_t::value_type));
constexpr std::size_t kObject = allocated(sizeof(json::object_t)), kArray = allocated(sizeof(json::array_t)),
                      kString = allocated(sizeof(json::string_t));

std::size_t text_bytes(const std::string& text) {
  static const std::size_t kInPlace = std::string().capacity();
  return text.capacity() > kInPlace ? allocated(text.capacity() + 1) : 0;
}

/// Builds the value from the parser's events. Every function returns whether to continue.
class Builder final : public nlohmann::json_sax<json> {
 public:
  Builder(const JsonLimits& limits, const Execution& execution) : limits_(limits), pacer_(execution) {}

  bool null() override { return add(nullptr, 0); }
  bool boolean(bool value) override { return add(value, 0); }
  bool number_integer(number_integer_t value) override { return add(value, 0); }
  bool number_unsigned(number_unsigned_t value) override { return add(value, 0); }
  bool number_float(number_float_t value, const string_t&) override { return add(value, 0); }
  bool string(string_t& value) override {
    const std::size_t bytes = kString + allocated(value.size() + 1);
    return add(value, bytes);
  }
  bool binary(binary_t&) override { return stop(JsonFault::Kind::kSyntax); }
  bool start_object(std::size_t) override { return open(json::value_t::object, kObject); }
  bool start_array(std::size_t) override { return open(json::value_t::array, kArray); }
  bool end_object() override { return close(); }
  bool end_array() override {
    auto& values = open_.back()->get_ref<json::array_t&>();
    bytes_ -= allocated(values.capacity() * sizeof(json));
    values.shrink_to_fit();
    bytes_ += allocated(values.capacity() * sizeof(json));
    return close();
  }
  bool key(string_t& name) override {
    auto& members = open_.back()->get_ref<json::object_t&>();
    const auto [at, fresh] = members.try_emplace(name);
    if (!fresh) {
      fault_.name = name.substr(0, 100);
      return stop(JsonFault::Kind::kRepeated);
    }
    if (open_.size() == 1) names_.push_back(name);
    member_ = &at->second;
    return count(kMember + text_bytes(at->first));
  }
  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception&) override {
    fault_.byte = position;
    return stop(JsonFault::Kind::kSyntax);
  }

  tl::expected<JsonDocument, JsonFault> take(bool whole) && {
    if (!whole) return tl::unexpected<JsonFault>(std::move(fault_));
    return JsonDocument{std::move(root_), std::move(names_)};
  }

 private:
  bool stop(JsonFault::Kind kind) {
    fault_.kind = kind;
    return false;
  }
  bool count(std::size_t bytes) {
    pacer_.step(8 + bytes / 16);
    bytes_ += bytes;
    return bytes_ <= limits_.bytes || stop(JsonFault::Kind::kTooLarge);
  }
  /// The position of the next value: after a key, at the end of the innermost array, or the root.
  json& place() {
    if (open_.empty()) return root_;
    if (!open_.back()->is_array()) return *member_;
    auto& values = open_.back()->get_ref<json::array_t&>();
    const std::size_t before = values.capacity();
    json& value = values.emplace_back();
    if (values.capacity() != before)
      bytes_ += allocated(values.capacity() * sizeof(json)) - allocated(before * sizeof(json));
    return value;
  }
  template <class Value>
  bool add(Value&& value, std::size_t bytes) {
    if (!count(bytes)) return false;
    place() = std::forward<Value>(value);
    return count(0);
  }
  bool open(json::value_t type, std::size_t bytes) {
    if (open_.size() >= limits_.depth) return stop(JsonFault::Kind::kTooDeep);
    json& value = place();
    value = json(type);
    open_.push_back(&value);  // stays valid: nothing is added to the parent before this is closed
    return count(bytes);
  }
  bool close() {
    open_.pop_back();
    return true;
  }

  const JsonLimits limits_;
  Pacer pacer_;
  json root_;
  std::vector<std::string> names_;
  std::vector<json*> open_;
  json* member_ = nullptr;
  std::size_t bytes_ = 0;
  JsonFault fault_;
};

}  // namespace

tl::expected<JsonDocument, JsonFault> read_json(std::string_view text, const JsonLimits& limits,
                                                const Execution& execution) {
  constexpr std::size_t kAsHashed = 32;  // parsing a byte takes as long as hashing this many
  count_bulk(kAsHashed * text.size());
  // The library treats a NUL as the end of the text, even if more text follows.
  if (const std::size_t nul = text.find('\0'); nul != std::string_view::npos)
    return tl::unexpected<JsonFault>({.kind = JsonFault::Kind::kSyntax, .byte = nul + 1});
  Builder builder(limits, execution);
  const bool whole = json::sax_parse(text.begin(), text.end(), &builder);
  auto read = std::move(builder).take(whole);
  if (!read && read.error().kind == JsonFault::Kind::kSyntax)
    read.error().at_end = read.error().byte > text.size();
  return read;
}

std::string to_text(const JsonFault& fault) {
  switch (fault.kind) {
    case JsonFault::Kind::kSyntax:
      if (fault.at_end) return "ends before its JSON is complete (byte " + grouped(fault.byte) + ")";
      return "is not valid JSON (error at byte " + grouped(fault.byte) + ")";
    case JsonFault::Kind::kTooDeep:
      return "is nested too deeply";
    case JsonFault::Kind::kTooLarge:
      return "contains too many values";
    case JsonFault::Kind::kRepeated:
      return "names '" + fault.name + "' more than once";
  }
  return "";
}

std::size_t json_bytes(const json& value) {
  // Values may be nested as deeply as their parser allowed, so this uses a list instead of recursion.
  std::size_t bytes = 0;
  std::vector<const json*> left = {&value};
  while (!left.empty()) {
    const json& v = *left.back();
    left.pop_back();
    if (const auto* text = v.get_ptr<const json::string_t*>()) {
      bytes += kString + text_bytes(*text);
    } else if (const auto* values = v.get_ptr<const json::array_t*>()) {
      bytes += kArray + allocated(values->capacity() * sizeof(json));
      for (const json& child : *values)
        if (child.is_structured() || child.is_string()) left.push_back(&child);
    } else if (const auto* members = v.get_ptr<const json::object_t*>()) {
      bytes += kObject;
      for (const auto& [name, child] : *members) {
        bytes += kMember + text_bytes(name);
        if (child.is_structured() || child.is_string()) left.push_back(&child);
      }
    }
  }
  return bytes;
}

}  // namespace fracture
