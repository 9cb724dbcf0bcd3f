// The volumes in a 3MF file that a slicer does not print, from the slicer's own configuration.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace fracture::threemf {

/// Volumes that a slicer does not print, by their ids in its configuration.
struct Modifiers {
  std::map<std::uint32_t, std::vector<std::array<std::uint32_t, 2>>>
      triangles;                    ///< PrusaSlicer: per object, first and last
  std::set<std::uint32_t> objects;  ///< Bambu Studio, OrcaSlicer
};

/// Adds the ranges of triangles that PrusaSlicer does not print. `text`: Metadata/Slic3r_PE_model.config.
void read_prusa(const std::string& text, Modifiers& modifiers);

/// Adds the objects that Bambu Studio and OrcaSlicer do not print. `text`: Metadata/model_settings.config.
void read_bambu(const std::string& text, Modifiers& modifiers);

}  // namespace fracture::threemf
