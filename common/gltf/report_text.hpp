// Writes the pipeline's report on an answer (pipeline/report.hpp) as the members `report` and `certificate` of
// extras.fracture. The report's members are in alphabetical order; those that were not requested are absent.
#pragma once

#include <nlohmann/json.hpp>

#include "common/gltf/json_text.hpp"
#include "common/pipeline/fractured_solid.hpp"

namespace fracture {

/// Writes {anchors {fragments}, barycenter {dropped, dropped_volume, partition, skipped_hulls}, choices (if there are any;
/// see choices_document()), contacts {…}, dropped (if anything is: a list of {name, reason, what}), fragment
/// {id, volume}, frame {metres_per_unit, offset, unit_from, up, up_from}, hulls {count, flat, simplified, excess},
/// instances {fragments, shapes}, keep {cells, share},
/// levels [number of clusters in each, then of fragments], notes, passed_through {triangles}, rough_cuts
/// {amplitude, amplitude_asked, calmed_vertices, crossing_triangles, edge_length, restrained_cells, triangles},
/// sites {duplicates_merged, far_dropped, given, used}, size {…}, solid {…}, support {…}, warnings}.
void write_report(JsonText& json, const FracturedSolid& fractured);

/// Writes {anchored, bonds {bending, shear, stress, tension, torsion}, broken, density, falling, gravity, residual,
/// strength, unknown, weak {a, b, share, stress}}. Fragments are given by id. The columns of `bonds` are in the order
/// of the answer's bonds.
void write_support(JsonText& json, const FragmentSet& set, const Support& support);

/// Returns the report's member `choices`: a list of {kind, parameters {name: value}, text}.
nlohmann::json choices_document(const std::vector<Choice>& choices);

/// Returns the report's member `dropped`: a list of {name, reason, what}.
nlohmann::json dropped_document(const std::vector<Dropped>& dropped);

/// Returns the report's member `contacts`: {alone, area, gap, listed {a, area, b, kind, normal, place, volume}, overlapping,
/// pairs, parts, touching, volume}. The columns of `listed` are in the order of ContactReport::listed.
nlohmann::json contacts_document(const ContactReport& contacts);

/// Writes a certificate. `rest` is {pairs, trimmed, filtered, left, deepest, tolerance, least_share, systems}, or null.
void write_certificate(JsonText& json, const Certificate& certificate, const std::optional<Rest>& rest);
/// Returns the certificate without `rest` as a document, with the same numbers as in a file.
nlohmann::json certificate_document(const Certificate& certificate);

}  // namespace fracture
