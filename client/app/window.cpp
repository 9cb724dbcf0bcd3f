#include "client/app/window.hpp"

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <future>
#include <utility>

#include "client/app/fly_camera.hpp"
#include "client/app/glfw_window.hpp"
#include "client/app/headless.hpp"
#include "client/app/hud.hpp"
#include "client/app/panel.hpp"
#include "client/app/recorded_options.hpp"
#include "client/app/rewind.hpp"
#include "client/app/scene_menu.hpp"
#include "client/app/sound_track.hpp"
#include "client/render/frame_target.hpp"
#include "client/sound/player.hpp"
#include "common/base/printable.hpp"

namespace fracture::app {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_between(Clock::time_point a, Clock::time_point b) {
  return std::chrono::duration<double>(b - a).count();
}

/// A scene and the camera in it, and everything that happens in a frame.
class Session {
 public:
  /// `recording`: of options.continue_from; null without one.
  Session(const Options& options, std::shared_ptr<const game::Recording> recording, GLFWwindow* window,
          view::SceneView view)
      : options_(options),
        window_(window),
        camera_(window),
        client_(options.server),
        view_(std::move(view)),
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
      if (button == GLFW_MOUSE_BUTTON_LEFT) session.use_tool();
    });
    state_.gravity_always = options.gravity;
    state_.sound = options.sound;
    state_.effects = options.effects;
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
  using Loaded = Expected<scenes::Scene>;

  // -- scenes: read on another thread, for some take longer than a frame

  void load(std::function<Loaded()> make) {
    // One that is overtaken is forgotten: its end is awaited in the background.
    if (loading_.valid())
      background(
          [overtaken = std::make_shared<std::future<Loaded>>(std::move(loading_))] { overtaken->wait(); });
    loading_ = std::async(std::launch::async, std::move(make));
    state_.loading = true;
  }
  /// Work that no frame waits for; the window's end does.
  void background(std::function<void()> work) {
    std::erase_if(background_, [](std::future<void>& f) {
      return f.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    });
    background_.push_back(std::async(std::launch::async, std::move(work)));
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
    if (!loading_.valid() || loading_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    Loaded scene = loading_.get();
    state_.loading = false;
    if (!scene) {
      note(scene.error().detail);
      return;
    }
    for (const std::string& warning : scene->warnings) note(warning);
    if (!game_ || game_->scene().name != scene->name || scene->name == "files") camera_.aim(*scene);
    // Another scene or a reset begins another game, and another recording.
    Options begun = options_;
    begun.parameters = recording_ ? options_.parameters : state_.overrides();
    nlohmann::json header = header_of(begun, *scene);
    if (recording_)
      if (const auto same = check_scene(recording_->header, *scene); !same) {
        note(same.error().detail);
        recording_.reset();
      }
    answers_ = std::make_shared<game::KeptAnswers>();
    retire(rewind_.clear());
    view_.reset();
    debris_ = effects::Debris(options_.seed);
    std::unique_ptr<game::Game> made = make_game(std::move(*scene), header, recording_);
    retire(std::move(game_));
    if (std::exchange(recording_, nullptr))
      rewind_.begin(std::move(made), options_.seed);
    else
      game_ = std::move(made);
  }

  /// A game that begins as the header says, or plays the recording of one that did.
  std::unique_ptr<game::Game> make_game(scenes::Scene scene, const nlohmann::json& header,
                                        std::shared_ptr<const game::Recording> recording) {
    game::GameSettings settings;
    settings.seed = options_.seed;
    settings.anticipate = options_.anticipate;
    settings.overrides = header.at("parameters");
    settings.world.max_witnessed = kMostWitnessed;
    settings.history = std::make_shared<game::History>(header);
    settings.answers = answers_;
    settings.replay = std::move(recording);
    // It may be the file of the game before it, of which nothing may come after this.
    if (game_ && game_->settings().recorder) game_->settings().recorder->finish();
    if (auto recorder = recorder_for(options_.log, header))
      settings.recorder = std::move(*recorder);
    else
      note(recorder.error().detail);
    return std::make_unique<game::Game>(std::move(scene), client_, std::move(settings));
  }

  /// Ends on another thread: its decoder may be at work.
  void retire(std::unique_ptr<game::Game> game) {
    if (game) background([old = std::shared_ptr<game::Game>(std::move(game))]() mutable { old.reset(); });
  }

  // -- the game's time

  void save_game() {
    if (!game_) return;
    const std::shared_ptr<game::History>& history = game_->settings().history;
    const std::string path = unused_name(options_.out, "game", ".jsonl");
    background([recording = std::make_shared<const game::Recording>(history->until(history->steps())), path] {
      if (const auto written = game::write_recording(path, *recording); !written)
        std::fprintf(stderr, "fracture-client: %s\n", written.error().detail.c_str());
    });
    note((history->full() ? "saved the beginning of this long game as " : "saved the game as ") + path +
         ": --continue plays it");
  }

  /// The key that goes back is held, or was: whether the game stands still for it.
  bool go_back(double seconds) {
    if (rewind_.playing()) {
      catch_up();
      return true;
    }
    if (down(GLFW_KEY_B)) {
      if (game_->settings().history->full()) {
        note("This game is too long to go back in. R begins another.");
        return false;
      }
      rewind_.hold(*game_, seconds);
      char text[64];
      std::snprintf(text, sizeof text, "%.1f s back", rewind_.seconds_back());
      note(text);
      return true;
    }
    if (!rewind_.held()) return false;
    const std::shared_ptr<game::History>& history = game_->settings().history;
    auto recording = std::make_shared<const game::Recording>(history->until(rewind_.release()));
    scenes::Scene scene = game_->scene();
    rewind_.begin(make_game(std::move(scene), recording->header, recording), options_.seed);
    return true;
  }

  void catch_up() {
    std::optional<Rewind::Played> played = rewind_.play_on();
    if (!played) {
      note("the game is played again: " + std::to_string(rewind_.percent()) + " %");
      return;
    }
    if (game_) view_.reset();  // else it has been seen all the time
    retire(std::exchange(game_, std::move(played->game)));
    debris_ = std::move(played->debris);
    note(played->diverged ? "Step " + std::to_string(*played->diverged) +
                                " is not what was recorded: the game goes on from there."
                          : "the game goes on");
  }

  /// Something for people, for some seconds.
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
        note(state_.slow_motion ? "a fifth of the speed" : "full speed");
        break;
      case GLFW_KEY_PERIOD:
        state_.gravity_always = false;
        single_step_ = true;
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
        note(options_.unit.empty() ? "unit: guessed by size" : "unit: " + options_.unit);
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
        save_game();
        break;
      case GLFW_KEY_R:
        load([options = options_] { return scene_of(options); });
        break;
      case GLFW_KEY_P:
        screenshot("fracture-" + std::to_string(++pictures_) + ".png");
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

  void use_tool() {
    if (!game_ || rewind_.playing() || rewind_.held()) return;
    const glm::dvec3 direction = camera_.aim_direction(), eye(camera_.eye());
    const scenes::Scene& scene = game_->scene();
    if (state_.tool == Tool::kExplosion) {
      constexpr double kFarthest = 200, kBefore = 0.1;  // metres: of the aim; in front of what is met
      const auto met = game_->world().first_met(eye, eye + kFarthest * direction);
      if (!met) return note("nothing is there to explode at");
      game_->explode({*met - kBefore * direction, scenes::kBlastImpulse, scenes::kBlastRadius});
    } else {
      const bool wrecks = state_.tool == Tool::kWreckingBall;
      const double radius = wrecks ? scenes::kWreckingBall.radius : scene.ball_radius;
      game_->throw_ball(eye + (radius + 0.3) * direction,
                        (wrecks ? scenes::kWreckingSpeed : scene.ball_speed) * direction,
                        wrecks ? scenes::kWreckingBall : scenes::Ball{});
    }
    if (!state_.gravity_always && !state_.gravity_held) note("Paused: hold X, or press G, and it happens.");
  }

  void screenshot(const std::string& name) {
    if (!target_) return;
    // Reading waits for the driver, as a picture on demand may; encoding and writing do not.
    const std::string path = (std::filesystem::path(options_.out) / name).string();
    background([picture = std::make_shared<const render::Picture>(target_->read()), path] {
      if (const auto written = render::write_png(*picture, path); !written)
        std::fprintf(stderr, "fracture-client: %s\n", written.error().detail.c_str());
    });
    note("saved " + path);
  }

  void save_glb() {
    const std::string path =
        (std::filesystem::path(options_.out) / ("fragments-" + std::to_string(++saved_) + ".glb")).string();
    background([glb = game_->last_glb(), path] {
      std::ofstream(path, std::ios::binary).write(glb->data(), static_cast<std::streamsize>(glb->size()));
    });
    note("saved " + path);
  }

  // -- a frame

  void frame(double seconds) {
    camera_.move(static_cast<float>(seconds));
    state_.gravity_held = down(GLFW_KEY_X);
    if (Clock::now() > note_until_) state_.note.clear();
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    if (width < 1 || height < 1) return;
    if (!target_ || target_->width() != width || target_->height() != height) {
      auto made = render::FrameTarget::create(width, height);
      if (!made) {
        note(made.error().detail);
        return;
      }
      target_ = std::make_unique<render::FrameTarget>(std::move(*made));
    }
    const render::Camera camera = view::look_at(camera_.eye(), camera_.eye() + camera_.forward(),
                                                static_cast<float>(width) / static_cast<float>(height));
    const Clock::time_point begin = Clock::now();
    state_.view.past = nullptr;
    if ((game_ || rewind_.playing()) && go_back(seconds)) {
      state_.view.past = game_ ? rewind_.shown() : nullptr;
      draw_game(game_ ? *game_ : *rewind_.playing(), camera, width, height);
    } else if (game_) {
      game_->set_eye(camera_.eye());
      constexpr double kSlow = 0.2;
      const double step = game_->settings().world.step;
      if (std::exchange(single_step_, false))
        game_->advance(1.001 * step, true);  // no rounding keeps it from being due
      else
        game_->advance(state_.slow_motion ? kSlow * seconds : seconds,
                       state_.gravity_always || state_.gravity_held);
      sense(game_->take_witnessed());
      rewind_.follow(*game_);
      if (!std::exchange(too_long_, game_->settings().history->full()) && too_long_)
        note(
            "This game is too long to be kept: F5 saves its beginning, and nothing goes back. R begins another.");
      draw_game(*game_, camera, width, height);
    }
    state_.frame_ms[state_.next_frame] = static_cast<float>(1e3 * seconds_between(begin, Clock::now()));
    state_.next_frame = (state_.next_frame + 1) % state_.frame_ms.size();
    target_->copy_to(0);
    overlay(camera, width, height);
    read_patterns();
  }

  void draw_game(const game::Game& game, const render::Camera& camera, int width, int height) {
    const auto drawn = view_.draw(game, camera, state_.view, target_->framebuffer(), width, height);
    if (drawn)
      state_.figures = *drawn;
    else
      note(drawn.error().detail);
  }

  /// What there was to see and hear.
  void sense(const world::Witnessed& witnessed) {
    debris_.follow(game_->world(), witnessed, materials_of(*game_));
    state_.view.debris = state_.effects ? &debris_ : nullptr;
    if (player_) {
      player_->set_volume(state_.volume);
      player_->hear(soundscape_.voices(witnessed, materials_of(*game_)), camera_.eye(), camera_.forward());
      state_.silent = player_->state() == sound::Player::State::kNoDevice;
    }
  }

  void overlay(const render::Camera& camera, int width, int height) {
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    if (game_) {
      constexpr int kEvery = 6;  // frames: it looks at every corner of every piece
      if (frames_++ % kEvery == 0) state_.census = game_->world().census();
      if (state_.view.debug == view::DebugView::kFragments && state_.view.past == nullptr)
        draw_fragment_ids(*game_, camera, width, height);
      // Which sets parameters: of a game that goes on.
      if (!rewind_.playing() && !rewind_.held())
        draw_panel(
            state_, *game_, client_,
            {[this](const std::string& scene) {
               options_.material.clear();
               load_scene(scene);
             },
             [this](const std::string& material) { set_material(material); },
             [this] { load([options = options_] { return scene_of(options); }); }, [this] { save_glb(); }});
      draw_hud(state_, *game_, client_);
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

  void read_patterns() {
    if (!state_.parameters.empty() || !game_) return;
    if (const std::string& text = game_->patterns(); !text.empty()) state_.parameters.read(text);
  }

  Options options_;
  GLFWwindow* window_;
  FlyCamera camera_;
  protocol::Client client_;
  view::SceneView view_;
  std::unique_ptr<game::Game> game_;
  std::shared_ptr<const game::Recording> recording_;  ///< to go on from, until its scene is there
  std::shared_ptr<game::KeptAnswers> answers_;        ///< of this game, however often it goes back
  Rewind rewind_;
  bool too_long_ = false;
  std::unique_ptr<render::FrameTarget> target_;
  std::unique_ptr<sound::Player> player_;  ///< null: silent
  sound::Soundscape soundscape_;
  effects::Debris debris_;
  std::unique_ptr<SceneMenu> menu_;  ///< once it was asked for
  PanelState state_;
  Clock::time_point note_until_{};
  std::future<Loaded> loading_;
  std::vector<std::future<void>> background_;
  bool look_always_ = false, single_step_ = false;
  int pictures_ = 0, saved_ = 0, frames_ = 0;
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
  std::error_code ignored;  // what cannot be written there says so then
  std::filesystem::create_directories(options.out, ignored);
  const auto window = GlfwWindow::open(options.width, options.height);
  if (!window) {
    std::fprintf(stderr, "fracture-client: no window: %s. --headless needs none.\n",
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
