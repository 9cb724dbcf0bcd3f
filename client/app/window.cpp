#include "client/app/window.hpp"

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <utility>

#include "client/app/background.hpp"
#include "client/app/fly_camera.hpp"
#include "client/app/glfw_window.hpp"
#include "client/app/headless.hpp"
#include "client/app/hud.hpp"
#include "client/app/output_places.hpp"
#include "client/app/panel.hpp"
#include "client/app/played_game.hpp"
#include "client/app/recorded_options.hpp"
#include "client/app/scene_loader.hpp"
#include "client/app/scene_menu.hpp"
#include "client/app/sound_track.hpp"
#include "client/app/window_picture.hpp"
#include "client/sound/player.hpp"
#include "common/base/printable.hpp"

namespace fracture::app {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_between(Clock::time_point a, Clock::time_point b) {
  return std::chrono::duration<double>(b - a).count();
}

/// The scene, the camera and everything that happens in a frame.
class Session {
 public:
  /// `recording` is the one named in options.continue_from, or null.
  Session(const Options& options, std::shared_ptr<const game::Recording> recording, GLFWwindow* window,
          view::SceneView view)
      : options_(options),
        window_(window),
        camera_(window),
        client_(options.server),
        picture_(std::move(view)),
        recording_(std::move(recording)) {
    glfwSetWindowUserPointer(window, this);
    glfwSetDropCallback(window, [](GLFWwindow* w, int count, const char** paths) {
      static_cast<Session*>(glfwGetWindowUserPointer(w))->load_files({paths, paths + count});
    });
    glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int) {
      if (action == GLFW_PRESS && !ImGui::GetIO().WantTextInput)
        static_cast<Session*>(glfwGetWindowUserPointer(w))->press(key);
    });
    glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int) {
      Session& session = *static_cast<Session*>(glfwGetWindowUserPointer(w));
      if (button == GLFW_MOUSE_BUTTON_RIGHT && action == GLFW_RELEASE)
        session.camera_.look(session.look_always_);
      if (action != GLFW_PRESS || ImGui::GetIO().WantCaptureMouse) return;
      if (button == GLFW_MOUSE_BUTTON_RIGHT) session.camera_.look(true);
      if (button == GLFW_MOUSE_BUTTON_LEFT) session.click();
    });
    state_.gravity_always = options.gravity;
    state_.sound = options.sound;
    state_.effects = options.effects;
    state_.picture = options.picture;
    if (options.sound) player_ = std::make_unique<sound::Player>();
    state_.given = options.parameters;
    load([options] { return scene_of(options); });
    client_.patterns();
  }

  void run() {
    Clock::time_point last = Clock::now();
    const Clock::time_point start = last;
    while (glfwWindowShouldClose(window_) == GLFW_FALSE) {
      glfwPollEvents();
      const Clock::time_point now = Clock::now();
      const double seconds = std::min(0.1, seconds_between(last, now));
      last = now;
      state_.frames_per_second += 0.05 * (1 / std::max(seconds, 1e-4) - state_.frames_per_second);
      take_loaded();
      frame(seconds);
      glfwSwapBuffers(window_);
      if (options_.close_after > 0 && seconds_between(start, now) > options_.close_after) {
        screenshot("window.png");
        break;
      }
    }
  }

 private:
  // -- scenes

  void load(std::function<SceneLoader::Loaded()> make) {
    loader_.begin(std::move(make));
    state_.loading = true;
  }
  void load_scene(const std::string& name) {
    options_.scene = name;
    options_.files.clear();
    load([options = options_] { return scene_of(options); });
  }
  void load_files(std::vector<std::string> paths) {
    options_.files = std::move(paths);
    load([options = options_] { return scene_of(options); });
  }
  void set_material(const std::string& name) {
    options_.material = name;
    note("material: " + name);
    load([options = options_] { return scene_of(options); });
  }

  void take_loaded() {
    std::optional<SceneLoader::Loaded> loaded = loader_.take();
    if (!loaded) return;
    SceneLoader::Loaded& scene = *loaded;
    state_.loading = false;
    if (!scene) {
      note(scene.error().detail);
      return;
    }
    for (const std::string& warning : scene->warnings) note(warning);
    if (game_.now() == nullptr || game_.seen()->simulation.scene().name != scene->name ||
        scene->name == "files")
      camera_.aim(*scene);
    // Another scene or a reset begins a new game and a new recording.
    Options begun = options_;
    begun.parameters = recording_ ? options_.parameters : state_.overrides();
    nlohmann::json header = header_of(begun, *scene);
    if (recording_)
      if (const auto same = check_scene(recording_->header, *scene); !same) {
        note(same.error().detail);
        recording_.reset();
      }
    picture_.reset();
    game_.begin(std::move(*scene), options_, header, std::exchange(recording_, nullptr));
  }

  /// Shows a message for some seconds.
  void note(std::string text) {
    constexpr std::chrono::seconds kShown(6);
    state_.note = std::move(text);
    note_until_ = Clock::now() + kShown;
  }

  // -- events

  bool down(int key) const { return !ImGui::GetIO().WantTextInput && glfwGetKey(window_, key) == GLFW_PRESS; }

  void press(int key) {
    const auto& materials = scenes::material_names();
    if (key >= GLFW_KEY_1 && key < GLFW_KEY_1 + static_cast<int>(materials.size()))
      return set_material(materials[static_cast<std::size_t>(key - GLFW_KEY_1)]);
    switch (key) {
      case GLFW_KEY_ESCAPE:
        if (state_.menu)
          state_.menu = false;
        else if (camera_.looks())
          camera_.look(look_always_ = false);
        else
          glfwSetWindowShouldClose(window_, GLFW_TRUE);
        break;
      case GLFW_KEY_T:
        state_.slow_motion = !state_.slow_motion;
        note(state_.slow_motion ? "one fifth of full speed" : "full speed");
        break;
      case GLFW_KEY_PERIOD:
        state_.gravity_always = false;
        game_.step_once();
        break;
      case GLFW_KEY_M:
        state_.menu = !state_.menu;
        if (state_.menu) camera_.look(look_always_ = false);
        break;
      case GLFW_KEY_U: {
        if (options_.files.empty()) break;
        static const std::vector<std::string> kUnits = {"", "m", "cm", "mm", "inch"};
        const auto at = std::find(kUnits.begin(), kUnits.end(), options_.unit);
        options_.unit = at == kUnits.end() || at + 1 == kUnits.end() ? kUnits.front() : *(at + 1);
        note(options_.unit.empty() ? "unit: guessed from the size" : "unit: " + options_.unit);
        load([options = options_] { return scene_of(options); });
        break;
      }
      case GLFW_KEY_G:
        state_.gravity_always = !state_.gravity_always;
        break;
      case GLFW_KEY_H:
        state_.help = !state_.help;
        break;
      case GLFW_KEY_F1:
        state_.panel = !state_.panel;
        break;
      case GLFW_KEY_F:
        state_.tool = static_cast<Tool>((static_cast<std::size_t>(state_.tool) + 1) % kToolActions.size());
        break;
      case GLFW_KEY_F5:
        game_.save(options_.out);
        break;
      case GLFW_KEY_R:
        load([options = options_] { return scene_of(options); });
        break;
      case GLFW_KEY_P:
        screenshot("fracture-" + std::to_string(++screenshots_) + ".png");
        break;
      case GLFW_KEY_V:
        state_.view.debug = static_cast<view::DebugView>((static_cast<int>(state_.view.debug) + 1) %
                                                         static_cast<int>(view::kDebugViewNames.size()));
        break;
      case GLFW_KEY_N: {
        const auto names = scenes::scene_names();
        const auto at = std::find(names.begin(), names.end(), options_.scene);
        options_.material.clear();
        load_scene(at == names.end() || at + 1 == names.end() ? names.front() : *(at + 1));
        break;
      }
      case GLFW_KEY_TAB:
        camera_.look(look_always_ = !camera_.looks());
        break;
      default:
        break;
    }
  }

  void click() {
    if (!game_.goes_on()) return;
    game_.use(state_.tool, glm::dvec3(camera_.eye()), camera_.aim_direction());
    if (!state_.gravity_always && !state_.gravity_held) note("Paused. Hold X or press G to continue.");
  }

  void screenshot(const std::string& name) {
    auto picture = picture_.read();
    if (!picture) return;
    // Reading waits for the driver. Encoding and writing run in the background.
    const std::string path = (std::filesystem::path(options_.out) / name).string();
    background_.write_picture(std::move(picture), path);
    note("saved " + path);
  }

  void save_glb() {
    const std::string path =
        (std::filesystem::path(options_.out) / ("fragments-" + std::to_string(++saved_) + ".glb")).string();
    background_.write_bytes(game_.now()->last_glb, path);
    note("saved " + path);
  }

  // -- a frame

  void frame(double seconds) {
    camera_.move(static_cast<float>(seconds));
    if (const LiveGame* seen = game_.seen()) {
      const game::Moment& moment = game_.past() != nullptr ? *game_.past() : seen->playback.moment();
      camera_.follow(seen->simulation.scene(),
                     static_cast<double>(moment.step) * seen->simulation.step_length());
    }
    state_.gravity_held = down(GLFW_KEY_X);
    if (Clock::now() > note_until_) state_.note.clear();
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    if (width < 1 || height < 1) return;
    if (const auto ready = picture_.prepare(width, height); !ready) return note(ready.error().detail);
    const render::Camera camera = view::look_at(camera_.eye(), camera_.eye() + camera_.forward(),
                                                static_cast<float>(width) / static_cast<float>(height));
    const Clock::time_point begin = Clock::now();
    play(seconds);
    if (const LiveGame* seen = game_.seen()) draw_game(*seen, camera);
    state_.frame_ms[state_.next_frame] = static_cast<float>(1e3 * seconds_between(begin, Clock::now()));
    state_.next_frame = (state_.next_frame + 1) % state_.frame_ms.size();
    picture_.show();
    overlay(camera, width, height);
  }

  /// Gives the game the frame's time and plays its sound.
  void play(double seconds) {
    constexpr double kSlow = 0.2;
    Tick tick;
    tick.seconds = state_.slow_motion ? kSlow * seconds : seconds;
    tick.running = state_.gravity_always || state_.gravity_held;
    tick.eye = camera_.eye();
    tick.loads = state_.view.debug == view::DebugView::kBonds || state_.figures.tier == render::Tier::kHigh;
    if (game_.frame(tick, seconds, down(GLFW_KEY_B))) picture_.reset();
    if (state_.parameters.empty() && !game_.patterns().empty()) state_.parameters.read(game_.patterns());
    std::vector<sound::Voice> voices = game_.take_voices();
    if (!player_) return;
    player_->set_volume(state_.volume);
    player_->hear(std::move(voices), camera_.eye(), camera_.forward());
    state_.silent = player_->state() == sound::Player::State::kNoDevice;
  }

  void draw_game(const LiveGame& live, const render::Camera& camera) {
    const game::Moment* past = game_.past();
    const std::vector<game::Game::Coming> coming = live.playback.coming();
    view::ViewSettings settings = state_.view;
    if (past != nullptr) {
      settings.debug = view::DebugView::kNone;  // debris is only known for the present
    } else {
      settings.coming = &coming;
      settings.debris = state_.effects ? &live.playback.debris() : nullptr;
    }
    const auto drawn =
        picture_.draw(live.simulation.scene(), past != nullptr ? *past : live.playback.moment(), camera,
                      settings, state_.picture);
    if (drawn)
      state_.figures = *drawn;
    else
      note(drawn.error().detail);
  }

  void overlay(const render::Camera& camera, int width, int height) {
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    if (const Snapshot* now = game_.now()) {
      const LiveGame& seen = *game_.seen();
      if (state_.view.debug == view::DebugView::kFragments && game_.past() == nullptr)
        draw_fragment_ids(seen.playback.moment(), camera, width, height);
      // The panel sets parameters, so the game must be going on.
      if (game_.goes_on())
        draw_panel(state_, seen.simulation.scene(), *now, client_,
                   {[this](const std::string& scene) {
                      options_.material.clear();
                      load_scene(scene);
                    },
                    [this](const std::string& material) { set_material(material); },
                    [this] { load([options = options_] { return scene_of(options); }); },
                    [this] { save_glb(); }, [this] { game_.set_overrides(state_.overrides()); }});
      draw_hud(state_, *now, client_);
    }
    draw_help(state_);
    if (state_.menu) {
      if (!menu_) menu_ = std::make_unique<SceneMenu>();
      if (menu_->draw([this](const std::string& scene) {
            options_.material.clear();
            load_scene(scene);
          }))
        state_.menu = false;
    }
    draw_hint(state_, camera_.aim_point());
    ImGui::Render();
    glViewport(0, 0, width, height);
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  }

  Options options_;
  GLFWwindow* window_;
  FlyCamera camera_;
  protocol::Client client_;
  WindowPicture picture_;
  std::shared_ptr<const game::Recording> recording_;  ///< to continue from; kept until its scene is loaded
  Background background_;
  PlayedGame game_{client_, background_, [this](std::string text) { note(std::move(text)); }};
  std::unique_ptr<sound::Player> player_;  ///< null: no sound
  std::unique_ptr<SceneMenu> menu_;        ///< created when first opened
  PanelState state_;
  Clock::time_point note_until_{};
  SceneLoader loader_{background_};
  bool look_always_ = false;
  int screenshots_ = 0, saved_ = 0;
};

}  // namespace

int run_window(const Options& asked) {
  Options options = asked;
  std::shared_ptr<const game::Recording> recording;
  if (!options.continue_from.empty()) {
    Expected<std::shared_ptr<const game::Recording>> read = recording_for(options, options.continue_from);
    if (!read) {
      std::fprintf(stderr, "fracture-client: %s\n", printable_lines(read.error().detail).c_str());
      return 1;
    }
    recording = std::move(*read);
  }
  std::error_code ignored;  // an error appears when a file is written there
  std::filesystem::create_directories(options.out, ignored);
  const auto window = GlfwWindow::open(options.width, options.height);
  if (!window) {
    std::fprintf(stderr, "fracture-client: cannot open a window: %s. Use --headless to run without one.\n",
                 window.error().detail.c_str());
    return 1;
  }
  auto view = view::SceneView::create();
  if (!view) {
    std::fprintf(stderr, "fracture-client: %s\n", view.error().detail.c_str());
    return 1;
  }
  Session session(options, std::move(recording), (*window)->get(), std::move(*view));
  (*window)->start_overlay();
  session.run();
  return 0;
}

}  // namespace fracture::app
