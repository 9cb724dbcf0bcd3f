// fracture-render: pictures of GLB files, without a window.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <iostream>
#include <nlohmann/json.hpp>

#include "client/cli/draw_list.hpp"
#include "client/cli/draw_picture.hpp"
#include "client/cli/sheet.hpp"
#include "client/egl/egl_context.hpp"
#include "client/render/image.hpp"
#include "common/base/exit_codes.hpp"
#include "common/base/printed_output.hpp"

namespace {

using fracture::Error;
using fracture::ErrorCode;
using fracture::Expected;
using fracture::cli::OptionSpec;
using fracture::cli::PictureMaker;
using fracture::cli::PictureOptions;

using fracture::kExitDone, fracture::kExitInternal, fracture::kExitRefused, fracture::kExitSystem,
    fracture::kExitUsage;

int exit_code(const Error& error) {
  switch (error.code) {
    case ErrorCode::kBadParameter:
      return kExitUsage;
    case ErrorCode::kFileAccess:
    case ErrorCode::kBadImage:
    case ErrorCode::kNoGraphics:
    case ErrorCode::kGraphicsDriver:
      return kExitSystem;
    default:
      return kExitRefused;
  }
}

struct Command {
  std::string output, sheet;
  nlohmann::json options = nlohmann::json::object();
  bool quiet = false, list = false;
};

Expected<void> run(const Command& command) {
  if (!command.list)
    if (auto may = fracture::render::may_write_png(command.output); !may) return may;
  PictureOptions options;
  fracture::cli::Sheet sheet;
  if (command.sheet.empty() && !command.list) {
    if (auto set = set_options(options, command.options, "The command line"); !set) return set;
  } else if (!command.list) {
    auto read = fracture::cli::read_sheet(command.sheet);
    if (!read) return tl::unexpected(read.error());
    sheet = std::move(*read);
  }
  const auto context = fracture::egl::EglContext::create();
  if (!context) return tl::unexpected(context.error());
  auto maker = PictureMaker::create();
  if (!maker) return tl::unexpected(maker.error());
  if (command.list) {
    fracture::cli::draw_list(std::cin, std::cout,
                             [&](const PictureOptions& one, const std::string& output) -> Expected<void> {
                               const Expected<fracture::render::Picture> picture = maker->draw(one);
                               maker->forget();
                               if (!picture) return tl::unexpected(picture.error());
                               return write_png(*picture, output);
                             });
    return {};
  }
  const Expected<fracture::render::Picture> picture =
      command.sheet.empty()
          ? maker->draw(options)
          : compose_sheet(sheet, [&](const PictureOptions& cell) { return maker->draw(cell); });
  if (!command.quiet)
    for (const std::string& warning : maker->warnings()) std::fprintf(stderr, "%s\n", warning.c_str());
  if (!picture) return tl::unexpected(picture.error());
  return write_png(*picture, command.output);
}

int run_program(int argc, char** argv) {
  CLI::App app("Renders GLB files to pictures without a window.", "fracture-render");
  Command command;
  app.add_option_function<std::string>(
      "input", [&](const std::string& file) { command.options["file"] = file; }, "GLB to render");
  app.add_option("-o,--output", command.output, "PNG to write");
  app.add_option("--sheet", command.sheet,
                 "Draw the table of pictures described by this JSON file (client/cli/sheet.hpp)");
  app.add_flag(
      "--list", command.list,
      "Draw one picture per line of standard input. A line is a JSON object with \"file\", \"output\" and any of "
      "these options. The program prints one line per picture (client/cli/draw_list.hpp)");
  app.add_flag("-q,--quiet", command.quiet, "Print no warnings");
  for (const OptionSpec& spec : fracture::cli::option_specs()) {
    const std::string name = spec.name;
    if (name == "file") continue;
    if (*spec.type == '\0')
      app.add_flag_function(
          "--" + name, [&command, name](std::int64_t) { command.options[name] = true; }, spec.doc);
    else
      app.add_option_function<std::string>(
             "--" + name, [&command, name](const std::string& value) { command.options[name] = value; },
             spec.doc)
          ->type_name(spec.type);
  }
  app.footer(
      "Exit code: 0 done, 1 a file or the display failed, 2 wrong command line, 3 the mesh was refused, 4 a "
      "bug.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitDone : kExitUsage;
  }
  if (command.list) {
    if (!command.sheet.empty() || !command.output.empty() || !command.options.empty()) {
      std::fprintf(
          stderr,
          "fracture-render: --list takes no other options. Put them into the lines of standard input.\n");
      return kExitUsage;
    }
  } else if (command.output.empty()) {
    std::fprintf(stderr, "fracture-render: --output is required. Specify the PNG to write.\n");
    return kExitUsage;
  } else if (command.sheet.empty() != command.options.contains("file")) {
    std::fprintf(stderr, "fracture-render: specify either a GLB or --sheet.\n");
    return kExitUsage;
  }
  if (!command.sheet.empty() && !command.options.empty()) {
    std::fprintf(stderr,
                 "fracture-render: --sheet takes no picture options. Put them into the sheet's file.\n");
    return kExitUsage;
  }
  try {
    const Expected<void> done = run(command);
    if (done) return kExitDone;
    std::fprintf(stderr, "fracture-render: %s\n", done.error().detail.c_str());
    return exit_code(done.error());
  } catch (const std::exception& bug) {
    std::fprintf(stderr, "fracture-render: a bug: %s\n", bug.what());
    return kExitInternal;
  }
}

}  // namespace

int main(int argc, char** argv) {
  fracture::occupy_standard_streams();
  return fracture::finish_printed("fracture-render", run_program(argc, argv));
}
