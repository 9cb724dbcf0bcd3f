// The only translation unit with tinygltf's code. Its warnings are ignored because it is third-party code.
#include <fstream>  // tinygltf's writers, unused here, need the type
#include <sstream>

#define TINYGLTF_IMPLEMENTATION
#include "common/import/tinygltf_renamed.hpp"
