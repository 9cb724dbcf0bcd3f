// tinygltf 2.7, compiled once in tinygltf_renamed.cpp in a separate namespace. libdraco.so.7, a dependency of
// Assimp, exports the symbols of another build of tinygltf. Under the original name, the two builds would mix
// and crash. Every file that uses tinygltf includes this header, so that all see the same macros, which
// change the layout of its classes.
//
// TINYGLTF_ENABLE_DRACO stays off: Draco primitives are decoded before tinygltf sees the document
// (gltf_compression.hpp), with this project's checks. TINYGLTF_NO_FS: it cannot open files.
#pragma once

#define tinygltf fracture_tinygltf
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_INCLUDE_JSON
#define TINYGLTF_NO_FS
#include <nlohmann/json.hpp>

#include <tiny_gltf.h>  // after the JSON library, which it expects to find
#undef tinygltf

namespace tinygltf = fracture_tinygltf;
