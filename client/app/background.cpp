#include "client/app/background.hpp"

#include <chrono>
#include <cstdio>
#include <fstream>
#include <utility>

namespace fracture::app {

void Background::run(std::function<void()> work) {
  std::erase_if(working_, [](std::future<void>& f) {
    return f.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  });
  working_.push_back(std::async(std::launch::async, std::move(work)));
}

void Background::write_picture(std::shared_ptr<const render::Picture> picture, const std::string& path) {
  run([picture = std::move(picture), path] {
    if (const auto written = render::write_png(*picture, path); !written)
      std::fprintf(stderr, "fracture-client: %s\n", written.error().detail.c_str());
  });
}

void Background::write_bytes(std::shared_ptr<const std::string> bytes, const std::string& path) {
  run([bytes = std::move(bytes), path] {
    std::ofstream file(path, std::ios::binary);
    if (!file.write(bytes->data(), static_cast<std::streamsize>(bytes->size())).flush())
      std::fprintf(stderr, "fracture-client: %s could not be written.\n", path.c_str());
  });
}

void Background::write_recording(std::future<game::Recording> recording, const std::string& path) {
  run([recording = std::make_shared<std::future<game::Recording>>(std::move(recording)), path] {
    if (const auto written = game::write_recording(path, recording->get()); !written)
      std::fprintf(stderr, "fracture-client: %s\n", written.error().detail.c_str());
  });
}

}  // namespace fracture::app
