#include "client/app/scene_loader.hpp"

#include <chrono>
#include <memory>
#include <utility>

namespace fracture::app {

void SceneLoader::begin(std::function<Loaded()> make) {
  if (loading_.valid())
    background_.run(
        [overtaken = std::make_shared<std::future<Loaded>>(std::move(loading_))] { overtaken->wait(); });
  loading_ = std::async(std::launch::async, std::move(make));
}

std::optional<SceneLoader::Loaded> SceneLoader::take() {
  if (!loading_.valid() || loading_.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
    return std::nullopt;
  return loading_.get();
}

}  // namespace fracture::app
