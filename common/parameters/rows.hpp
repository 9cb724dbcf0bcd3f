// The rows of the table of parameters.
#pragma once

#include <vector>

#include "common/parameters/parameters.hpp"

namespace fracture {

using Type = ParameterSpec::Type;  // the rows name it some hundred times

/// Every parameter, in the order in which they apply and are listed. `max_sites` and `formats` are the
/// server's.
std::vector<ParameterSpec> parameter_rows(std::uint32_t max_sites, const FormatSet& formats);

/// The part of it that decides where the sites go; `material` and `pattern` come first.
std::vector<ParameterSpec> site_parameter_rows(std::uint32_t max_sites);

/// The part of it about sizes, levels, regions, anchors and support, and fracturing a part again.
std::vector<ParameterSpec> structure_parameter_rows(std::uint32_t max_sites);

/// The part of that about hits on what is fractured.
std::vector<ParameterSpec> hit_parameter_rows();

/// The part of it about rough cuts.
std::vector<ParameterSpec> rough_parameter_rows();

/// kBadParameter with the parameter's name.
Error bad_parameter(std::string name, std::string detail);

/// Makes values of several parameters of one (a region of centre and radius, …). kBadParameter where one is
/// missing or they contradict each other.
std::optional<Error> complete_structure(RequestParameters& parameters);
/// The part of it for hits.
std::optional<Error> complete_hits(RequestParameters& parameters);

/// Names of the patterns for which this is true.
std::vector<std::string> patterns_that(bool PatternTraits::*may);

/// The pattern of this number, all its parameters at their defaults.
SitePattern default_pattern(std::size_t index);

/// Does the parameter mean anything for this pattern?
bool belongs(const ParameterSpec& spec, const SitePattern& pattern);

}  // namespace fracture
