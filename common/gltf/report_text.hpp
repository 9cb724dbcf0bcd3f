// What the pipeline says of an answer (pipeline/report.hpp), as the members `report` and `certificate` of
// extras.fracture. Names stand in their alphabetical order; what was not asked for is not there.
#pragma once

#include <nlohmann/json.hpp>

#include "common/gltf/json_text.hpp"
#include "common/pipeline/fractured_solid.hpp"

namespace fracture {

/// {anchors {fragments}, barycenter {dropped, dropped_volume, partition, skipped_hulls}, contacts {…}, fragment
/// {id, volume}, frame {metres_per_unit, unit_from, up, up_from}, hulls {count, flat, simplified, excess}, keep {cells},
/// levels [how many clusters each has, at last fragments], notes, passed_through {triangles}, rough_cuts
/// {amplitude, amplitude_asked, calmed_vertices, crossing_triangles, edge_length, restrained_cells, triangles},
/// sites {duplicates_merged, far_dropped, given, used}, size {…}, solid {…}, support {…}, warnings}
void write_report(JsonText& json, const FracturedSolid& fractured);

/// {anchored, bonds {bending, shear, stress, tension, torsion}, broken, density, falling, gravity, residual,
/// strength, unknown, weak {a, b, share, stress}}: ids of fragments; the columns of `bonds` stand in the order
/// of the answer's bonds.
void write_support(JsonText& json, const FragmentSet& set, const Support& support);

/// The member `contacts` of a report: {alone, area, gap, listed {a, area, b, kind, normal, place, volume}, overlapping,
/// pairs, parts, touching, volume}. The columns of `listed` are in the order of ContactReport::listed.
nlohmann::json contacts_document(const ContactReport& contacts);

/// Its member `rest` is {pairs, trimmed, filtered, left, deepest, tolerance, least_share, systems}, or null without hulls.
void write_certificate(JsonText& json, const Certificate& certificate, const std::optional<Rest>& rest);
/// The same without `rest`, as a document, with its numbers as they are in a file.
nlohmann::json certificate_document(const Certificate& certificate);

}  // namespace fracture
