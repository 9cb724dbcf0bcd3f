// Messages about the files of a bake and their results.
#pragma once

#include <span>
#include <string>

#include "server/bake/baker.hpp"
#include "server/bake/output_files.hpp"

namespace fracture::bake {

std::string name_of_input(const std::string& path);
std::string name_of_output(const std::string& path);
/// Returns "cannot write fragments.glb" or "cannot write to standard output".
std::string cannot_write(const std::string& path);

/// Returns "fragments.glb: 50 fragments, input volume 1 m³, output volume 1 m³, relative error 2.2e-16, 0 open edges,
/// 51372 bytes, 0.006 s (import 0.1 ms, ...)". `written`: the output, followed by the files that were written
/// with it.
std::string sentence_of(std::span<const WrittenFile> written, const Baked& baked, double seconds);

}  // namespace fracture::bake
