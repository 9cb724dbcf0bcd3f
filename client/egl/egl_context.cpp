#include "client/egl/egl_context.hpp"

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <array>
#include <cstdio>
#include <utility>

namespace fracture::egl {

struct EglContext::State {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;
  std::string description;

  State() = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    if (display == EGL_NO_DISPLAY) return;
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (context != EGL_NO_CONTEXT) eglDestroyContext(display, context);
    eglTerminate(display);
  }
};

namespace {

std::string egl_error() {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "0x%04x", static_cast<unsigned>(eglGetError()));
  return std::string("EGL error ") + text.data();
}

/// Makes OpenGL 3.3 core current on the display. The text of a kNoGraphics error is only the reason.
Expected<EGLContext> open_context(EGLDisplay display) {
  const auto none = [](std::string why) { return fail(ErrorCode::kNoGraphics, std::move(why)); };
  EGLint major = 0, minor = 0;
  if (display == EGL_NO_DISPLAY) return none("no display");
  if (eglInitialize(display, &major, &minor) == EGL_FALSE) return none("not initialized, " + egl_error());
  if (!epoxy_has_egl_extension(display, "EGL_KHR_surfaceless_context"))
    return none("no surfaceless contexts");
  if (eglBindAPI(EGL_OPENGL_API) == EGL_FALSE) return none("no desktop OpenGL");
  constexpr EGLint kConfig[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, EGL_DONT_CARE,
                                EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (eglChooseConfig(display, kConfig, &config, 1, &count) == EGL_FALSE || count < 1)
    return none("no configuration for OpenGL");
  constexpr EGLint kAttributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                    3,
                                    EGL_CONTEXT_MINOR_VERSION,
                                    3,
                                    EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                    EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                    EGL_NONE};
  const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, kAttributes);
  if (context == EGL_NO_CONTEXT) return none("no OpenGL 3.3 core, " + egl_error());
  if (eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) == EGL_FALSE) {
    const std::string why = "cannot be made current, " + egl_error();
    eglDestroyContext(display, context);
    return none(why);
  }
  return context;
}

}  // namespace

EglContext::EglContext(std::unique_ptr<State> state) : state_(std::move(state)) {}
EglContext::EglContext(EglContext&&) noexcept = default;
EglContext& EglContext::operator=(EglContext&&) noexcept = default;
EglContext::~EglContext() = default;
const std::string& EglContext::description() const { return state_->description; }

Expected<EglContext> EglContext::create() {
  std::string complaints;
  const auto attempt = [&](const std::string& name, EGLDisplay display) -> std::unique_ptr<State> {
    auto state = std::make_unique<State>();
    state->display = display;
    const Expected<EGLContext> context = open_context(display);
    if (context) {
      state->context = *context;
      const auto text = [](GLenum what) {
        return std::string(reinterpret_cast<const char*>(glGetString(what)));
      };
      state->description = name + ": " + text(GL_RENDERER) + ", OpenGL " + text(GL_VERSION);
      return state;
    }
    complaints += (complaints.empty() ? "" : "; ") + name + ": " + context.error().detail;
    return nullptr;
  };
  const bool platforms = epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_base");
  if (platforms && epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless"))
    if (auto state = attempt("surfaceless", eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA,
                                                                     EGL_DEFAULT_DISPLAY, nullptr)))
      return EglContext(std::move(state));
  if (platforms && epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_enumeration") &&
      epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_device")) {
    std::array<EGLDeviceEXT, 8> devices{};
    EGLint count = 0;
    eglQueryDevicesEXT(static_cast<EGLint>(devices.size()), devices.data(), &count);
    for (EGLint k = 0; k < count; ++k)
      if (auto state = attempt("device " + std::to_string(k),
                               eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT,
                                                        devices[static_cast<std::size_t>(k)], nullptr)))
        return EglContext(std::move(state));
  }
  if (auto state = attempt("default display", eglGetDisplay(EGL_DEFAULT_DISPLAY)))
    return EglContext(std::move(state));
  return fail(ErrorCode::kNoGraphics,
              "No EGL display supports OpenGL 3.3 (Debian: libegl1, libegl-mesa0, libgl1-mesa-dri). " +
                  complaints + ".");
}

}  // namespace fracture::egl
