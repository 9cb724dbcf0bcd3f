#include "common/solid/size_check.hpp"

#include <array>
#include <cmath>
#include <string>

#include "common/base/words.hpp"

namespace fracture {
namespace {

/// m: sizes of most objects that are broken.
constexpr double kLeastUsual = 0.01, kMostUsual = 12;

struct UnitName {
  LengthUnit unit;
  const char* value;  ///< of the parameter `unit`
  const char* plural;
};
constexpr std::array<UnitName, 5> kUnits{{{LengthUnit::kMillimetre, "mm", "millimetres"},
                                          {LengthUnit::kCentimetre, "cm", "centimetres"},
                                          {LengthUnit::kInch, "inch", "inches"},
                                          {LengthUnit::kMetre, "m", "metres"},
                                          {LengthUnit::kKilometre, "km", "kilometres"}}};

const UnitName* named(LengthUnit unit) {
  for (const UnitName& each : kUnits)
    if (each.unit == unit) return &each;
  return nullptr;
}

const UnitName* named(double metres) {
  for (const UnitName& each : kUnits)
    if (metres_of(each.unit) == metres) return &each;
  return nullptr;
}

struct Sizes {
  double whole = 0, part = 0;  ///< m: the longest side of the solid, and of its largest part
};

Sizes sizes_of(const Solid& solid) {
  Sizes sizes;
  if (solid.parts.empty()) return sizes;
  sizes.whole = solid.box.longest_side();
  for (const Part& part : solid.parts) sizes.part = std::fmax(sizes.part, part.box.longest_side());
  return sizes;
}

bool cannot_be_meant(const Sizes& sizes) {
  return sizes.part > kMostObject || (sizes.whole > 0 && sizes.whole < kLeastObject);
}

/// `size`: m, what is too large or too small. `why`: the end of the sentence that says so.
void warn(double size, const std::string& what, const std::string& why, const FrameReport& frame,
          bool millimetres_first, Remarks& remarks, std::vector<Choice>& choices) {
  std::string text = what + " is " + short_number(size) + " m long, " + why + ". One unit of the file is " +
                     short_number(frame.metres_per_unit) + " m (" +
                     (frame.unit_from == FrameReport::From::kFile ? "as the file says" : "assumed") + ").";
  if (const auto unit = likely_unit(size, frame.metres_per_unit, millimetres_first)) {
    const UnitName& name = *named(*unit);
    const std::string then = short_number(size / frame.metres_per_unit * metres_of(*unit)) + " m long";
    text += std::string(" If the coordinates are in ") + name.plural + ", use unit=" + name.value +
            ": it is then " + then + ".";
    choices.push_back({.kind = "unit",
                       .parameters = {{"unit", std::string(name.value)}},
                       .text = what + " is " + short_number(size) + " m long, " + why +
                               ". If the coordinates are in " + name.plural + ", it is " + then + "."});
  } else {
    text += " Scale the mesh in a modelling tool.";
  }
  if (const UnitName* const now = named(frame.metres_per_unit))
    text += std::string(" If the size is right, use unit=") + now->value + ", and this warning goes away.";
  remarks.warn(std::move(text));
}

const char* name_of_largest(const Solid& solid) {
  return solid.parts.size() == 1 ? "The mesh" : "The largest part of the mesh";
}

}  // namespace

std::optional<LengthUnit> likely_unit(double longest, double metres_per_unit, bool millimetres_first) {
  using enum LengthUnit;
  const bool large = longest > kMostUsual;
  const std::array<LengthUnit, 3> smaller = millimetres_first ? std::array{kMillimetre, kCentimetre, kMetre}
                                                              : std::array{kCentimetre, kMillimetre, kMetre};
  const std::array<LengthUnit, 3> larger{kCentimetre, kMetre, kKilometre};
  std::optional<LengthUnit> nearest;
  double least = HUGE_VAL;
  for (const LengthUnit unit : large ? smaller : larger) {
    const double factor = metres_of(unit) / metres_per_unit, size = longest * factor;
    if (large ? !(factor < 1) : !(factor > 1)) continue;
    if (size >= kLeastUsual && size <= kMostUsual) return unit;
    if (const double miss = size > kMostUsual ? size / kMostUsual : kLeastUsual / size; miss < least) {
      least = miss;
      nearest = unit;
    }
  }
  return nearest;
}

void check_size(const Solid& solid, const FrameReport& frame, bool millimetres_first, Remarks& remarks,
                std::vector<Choice>& choices) {
  const Sizes sizes = sizes_of(solid);
  if (frame.unit_from == FrameReport::From::kRequest || !cannot_be_meant(sizes)) return;
  if (sizes.part > kMostObject)
    warn(sizes.part, name_of_largest(solid),
         "and few objects are longer than " + short_number(kMostObject) + " m", frame, millimetres_first,
         remarks, choices);
  else
    warn(sizes.whole, "The mesh", "and few objects are shorter than " + short_number(kLeastObject) + " m",
         frame, millimetres_first, remarks, choices);
}

void check_size(const Solid& solid, const FrameReport& frame, bool millimetres_first,
                const UsualPieces& pieces, Remarks& remarks, std::vector<Choice>& choices) {
  const Sizes sizes = sizes_of(solid);
  if (frame.unit_from == FrameReport::From::kRequest || cannot_be_meant(sizes) || !(pieces.size > 0) ||
      !(sizes.part > kMostPieces * pieces.size))
    return;
  warn(sizes.part, name_of_largest(solid),
       "more than " + grouped(static_cast<std::uint64_t>(kMostPieces)) +
           " times the usual size of pieces of " + std::string(pieces.material) + ", " +
           short_number(pieces.size) + " m",
       frame, millimetres_first, remarks, choices);
}

}  // namespace fracture
