// The rows of the parameter table.
#pragma once

#include <vector>

#include "common/parameters/parameters.hpp"

namespace fracture {

using Type = ParameterSpec::Type;  // for the rows

/// Returns every parameter, in the order in which parameters apply and are listed. `max_sites` and
/// `formats` are the server's.
std::vector<ParameterSpec> parameter_rows(std::uint32_t max_sites, const FormatSet& formats);

/// The rows that determine the solid.
std::vector<ParameterSpec> solid_parameter_rows();

/// The rows that determine the positions of the sites; `material` and `pattern` are first.
std::vector<ParameterSpec> site_parameter_rows(std::uint32_t max_sites);

/// The rows for parameters of single patterns, which are part of site_parameter_rows().
std::vector<ParameterSpec> pattern_parameter_rows(std::uint32_t max_sites);

/// The rows for sizes, levels, regions, anchors, support, hits, and fragments that break again.
std::vector<ParameterSpec> structure_parameter_rows(std::uint32_t max_sites);

/// The rows for local hits, which are part of structure_parameter_rows().
std::vector<ParameterSpec> hit_parameter_rows();

/// The rows for the number of collision hulls.
std::vector<ParameterSpec> hull_parameter_rows();

/// The rows for rough cuts.
std::vector<ParameterSpec> rough_parameter_rows();

/// The rows for mass, contact properties and the strength of bonds.
std::vector<ParameterSpec> physical_parameter_rows();

/// Returns an error kBadParameter with the parameter's name.
Error bad_parameter(std::string name, std::string detail);

/// Combines several parameters into one value, such as a region from centre and radius. Error:
/// kBadParameter if one is missing or if they contradict each other.
std::optional<Error> complete_structure(RequestParameters& parameters);
/// Combines the parameters of hits in the same way.
std::optional<Error> complete_hits(RequestParameters& parameters);
/// With barycentric cells, sets RequestParameters::idle_aggregation: they do not fill space, and groups of them would not either.
void drop_aggregation(RequestParameters& parameters);

/// Returns the names of the patterns for which the trait is true.
std::vector<std::string> patterns_that(bool PatternTraits::*may);

/// Returns the pattern with this index, with default parameters.
SitePattern default_pattern(std::size_t index);

/// Whether the parameter has a meaning for this pattern.
bool belongs(const ParameterSpec& spec, const SitePattern& pattern);

}  // namespace fracture
