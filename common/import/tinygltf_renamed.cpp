// The one translation unit that holds tinygltf's code (a third-party header: its warnings are not ours to
// mend).
#include <fstream>  // tinygltf's writers, unused here, need the type
#include <sstream>

#define TINYGLTF_IMPLEMENTATION
#include "common/import/tinygltf_renamed.hpp"
