// Vectors, lists of vectors and matrices, as text "1,2,3;4,5,6" or as nested JSON arrays. An error points to the wrong number.
#include <algorithm>
#include <string_view>
#include <utility>

#include "common/parameters/values.hpp"

namespace fracture {
namespace {

class VectorReader {
 public:
  VectorReader(const ParameterSpec& spec, const RawParameter& raw) : spec_(spec), raw_(raw) {}

  Expected<ParameterValue> vector() const {
    Expected<Vec3d> v = read(raw_.value, "");
    if (!v) return tl::unexpected<Error>(std::move(v.error()));
    return ParameterValue(*v);
  }

  Expected<ParameterValue> vectors(std::uint64_t least, std::uint64_t most) const {
    std::vector<nlohmann::json> items;
    bool single = false;
    if (raw_.is_text) {
      std::string_view text = raw_.value.get_ref<const std::string&>();
      if (static_cast<std::uint64_t>(std::count(text.begin(), text.end(), ';')) >= most) return too_many();
      for (std::size_t end = 0; end != std::string_view::npos;) {
        end = text.find(';');
        items.emplace_back(std::string(text.substr(0, end)));
        if (end != std::string_view::npos) text.remove_prefix(end + 1);
      }
    } else if (!raw_.value.is_array()) {
      return wrong(raw_.value, "");
    } else if (!raw_.value.empty() && raw_.value[0].is_number()) {
      single = true;
      items.push_back(raw_.value);
    } else if (raw_.value.size() > most) {
      return too_many();
    } else {
      items.assign(raw_.value.begin(), raw_.value.end());
    }
    if (items.size() < least) return wrong(raw_.value, "");
    std::vector<Vec3d> list;
    for (std::size_t k = 0; k < items.size(); ++k) {
      Expected<Vec3d> v = read(items[k], single ? std::string() : std::string("/").append(std::to_string(k)));
      if (!v) return tl::unexpected<Error>(std::move(v.error()));
      list.push_back(*v);
    }
    return ParameterValue(std::move(list));
  }

  Expected<ParameterValue> matrix() const {
    Expected<ParameterValue> rows = vectors(3, 3);
    if (!rows) return rows;
    const auto& list = std::get<std::vector<Vec3d>>(*rows);
    return ParameterValue(Matrix3{{list[0], list[1], list[2]}});
  }

 private:
  Expected<ParameterValue> too_many() const {
    return fail(ErrorCode::kBadParameter,
                "'" + spec_.name + "' must be " + expectation(spec_) + ", but there were more.");
  }
  /// `pointer`: to the value, relative to the parameter's value.
  tl::unexpected<Error> wrong(const nlohmann::json& value, const std::string& pointer) const {
    const std::string who = pointer.empty() ? "it" : "the value at " + pointer;
    return fail(
        ErrorCode::kBadParameter,
        "'" + spec_.name + "' must be " + expectation(spec_) + "; " + who + " was '" + shown(value) + "'.",
        pointer);
  }
  Expected<Vec3d> read(const nlohmann::json& item, const std::string& pointer) const {
    std::vector<nlohmann::json> numbers;
    if (raw_.is_text) {
      std::string_view text = item.get_ref<const std::string&>();
      for (std::size_t end = 0; end != std::string_view::npos && numbers.size() < 4;) {
        end = text.find(',');
        numbers.emplace_back(std::string(text.substr(0, end)));
        if (end != std::string_view::npos) text.remove_prefix(end + 1);
      }
    } else if (item.is_array() && item.size() == 3) {
      numbers.assign(item.begin(), item.end());
    }
    if (numbers.size() != 3) return wrong(item, pointer);
    Vec3d v;
    for (int a = 0; a < 3; ++a) {
      const nlohmann::json& given = numbers[static_cast<std::size_t>(a)];
      const std::optional<double> number = to_number(given, raw_.is_text);
      if (!number || *number < spec_.low || *number > spec_.high)
        return wrong(given, pointer + "/" + std::to_string(a));
      v[a] = *number;
    }
    return v;
  }

  const ParameterSpec& spec_;
  const RawParameter& raw_;
};

}  // namespace

Expected<ParameterValue> to_vectors(const ParameterSpec& spec, const RawParameter& raw) {
  const VectorReader reader(spec, raw);
  if (spec.type == ParameterSpec::Type::kMatrix) return reader.matrix();
  if (spec.type == ParameterSpec::Type::kVectors) return reader.vectors(spec.min, spec.max);
  return reader.vector();
}

}  // namespace fracture
