// A minimal game: prints the sizes of its broken assets.
#include <cstdio>
#include <fstream>

int main() {
  for (const char* path : {ASSETS}) {
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    if (!file) return 1;
    std::printf("%s: %lld bytes\n", path, static_cast<long long>(file.tellg()));
  }
}
