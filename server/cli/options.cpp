#include "server/cli/options.hpp"

#include <unistd.h>

#include <CLI/CLI.hpp>

namespace fracture::cli {
namespace {

/// A flag whose value is milliseconds of a chrono duration, written in seconds.
CLI::Option* add_seconds(CLI::App& app, const std::string& name, std::chrono::milliseconds& target,
                         const std::string& text) {
  return app
      .add_option_function<double>(
          name,
          [&target](const double& seconds) {
            target = std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000));
          },
          text + " (seconds)")
      ->check(CLI::Range(0.0, 86400.0))
      ->default_str(std::to_string(target.count() / 1000.0).substr(0, 5));
}

void add_formats(CLI::App& app, FormatSet& formats) {
  app.add_option_function<std::vector<std::string>>(
         "--enable-format",
         [&formats](const std::vector<std::string>& names) {
           for (const std::string& name : names) {
             const auto format = format_from_extension(name);
             if (!format) throw CLI::ValidationError("--enable-format", "there is no format '" + name + "'");
             formats.enable(*format);
           }
         },
         "Also read this format (blend, fbx, dae, 3ds and others): their parsers are large and off by "
         "default")
      ->delimiter(',');
  app.add_flag_callback(
      "--all-formats", [&formats] { formats = FormatSet::all(); }, "Read every format there is");
}

void add_serve(CLI::App& app, ServeOptions& o) {
  app.add_option("--address", o.server.address, "Numeric address of both listeners")->capture_default_str();
  app.add_option("--port", o.server.port, "Port of the public listener, 0: any free one")
      ->capture_default_str();
  app.add_option("--admin-port", o.server.admin_port, "Port of /livez and /readyz, 0: any free one")
      ->capture_default_str();
  app.add_option("--io-threads", o.server.io_threads, "Threads that read and write")
      ->check(CLI::Range(1, 2))
      ->capture_default_str();
  app.add_option("--threads", o.threads, "Threads that compute, 0: one for each core")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app.add_option("--max-queue", o.max_queue, "Requests that may wait for a computing thread")
      ->capture_default_str();
  app.add_option("--log-level", o.log_level, "")
      ->check(CLI::IsMember({"trace", "debug", "info", "warn", "error", "off"}))
      ->capture_default_str();
  add_formats(app, o.service.formats);

  CLI::App& limits = *app.add_option_group("Limits");
  limits.add_option("--max-body", o.limits.max_body, "Bytes of a request body")->capture_default_str();
  limits.add_option("--max-bodies", o.limits.max_bodies, "Bytes of all request bodies held at the same time")
      ->capture_default_str();
  limits.add_option("--max-header", o.limits.max_header, "Bytes of a request header")
      ->check(CLI::Range(std::size_t{256}, http::kReadBuffer / 2))
      ->capture_default_str();
  limits.add_option("--max-uri", o.limits.max_uri, "Bytes of a request target")->capture_default_str();
  limits.add_option("--max-sites", o.service.max_sites, "Sites of one request")
      ->check(CLI::Range(1, 10'000'000))
      ->capture_default_str();
  limits.add_option("--max-triangles", o.service.import_limits.max_triangles, "Triangles of one mesh")
      ->capture_default_str();
  limits
      .add_option("--max-decoded", o.service.import_limits.max_decoded_bytes,
                  "Bytes of a mesh after decompression")
      ->capture_default_str();
  limits.add_option("--max-connections", o.limits.max_connections, "Open connections")->capture_default_str();
  limits
      .add_option("--max-connections-per-address", o.limits.max_connections_per_address,
                  "Open connections of one client address")
      ->capture_default_str();
  add_seconds(limits, "--deadline", o.limits.deadline, "Longest computation, with its time in the queue");
  add_seconds(limits, "--header-timeout", o.limits.header_timeout, "Time for a whole header");
  add_seconds(limits, "--body-grace", o.limits.body_grace, "Time before a body must keep up its rate");
  limits.add_option("--body-rate", o.limits.body_rate, "Bytes a second that a body must keep up")
      ->capture_default_str();
  add_seconds(limits, "--write-stall", o.limits.write_stall, "Longest time without the client taking a byte");
  add_seconds(limits, "--idle", o.limits.idle, "Longest time between requests of a connection");

  CLI::App& caches = *app.add_option_group("Caches");
  caches.add_option("--mesh-cache", o.service.mesh_cache_bytes, "Bytes of prepared meshes")
      ->capture_default_str();
  caches.add_option("--diagram-cache", o.service.diagram_cache_bytes, "Bytes of tetrahedralizations")
      ->capture_default_str();
  caches.add_option("--result-cache", o.service.result_cache_bytes, "Bytes of finished answers")
      ->capture_default_str();

  CLI::App& stopping = *app.add_option_group("Stopping");
  add_seconds(stopping, "--drain-delay", o.drain_delay,
              "After SIGTERM, keep accepting for this long with /readyz at 503; 0 by default on a terminal");
  add_seconds(stopping, "--grace", o.grace, "Then finish what is in progress for at most this long");
}

/// Parameters are taken as text and checked by the service's table: one validation for every way to ask.
template <class Options>
void add_parameters(CLI::App& app, Options& o) {
  const ParameterTable table(o.service.max_sites, FormatSet::all());
  for (const ParameterSpec& spec : table.specs()) {
    CLI::Option* option = app.add_option_function<std::string>(
        "--" + spec.name,
        [&o, name = spec.name](const std::string& value) {
          o.parameters.push_back({name, value, true});
        },
        spec.doc);
    if (!spec.default_value.is_null())
      option->default_str(spec.default_value.is_string() ? spec.default_value.get<std::string>()
                                                         : spec.default_value.dump());
  }
  app.add_option("--threads", o.threads, "Threads that compute, 0: one for each core")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
}

void add_bake(CLI::App& app, BakeOptions& o) {
  app.add_option("input", o.input, "Mesh file")->required();
  app.add_option("-o,--output", o.output, "File to write: .gltf as one JSON text, everything else GLB")
      ->required();
  add_parameters(app, o);
  app.add_flag("-q,--quiet", o.quiet, "No progress and no summary");
}

void add_inspect(CLI::App& app, InspectOptions& o) {
  app.add_option("input", o.input, "Mesh file")->required();
  app.add_flag("--json", o.json, "The report as JSON");
  add_parameters(app, o);
}

}  // namespace

int run(int argc, char** argv) {
  CLI::App app("Exact, watertight mesh fracture: as a service (serve) or for one file (bake).",
               "fracture-server");
  app.set_version_flag("--version",
                       "fracture-server " FRACTURE_VERSION " algorithm " + std::to_string(kAlgorithmVersion));
  app.require_subcommand(1);

  ServeOptions serve_options;
  serve_options.drain_delay = std::chrono::milliseconds(::isatty(STDERR_FILENO) ? 0 : 5'000);
  CLI::App& serve_command = *app.add_subcommand("serve", "Answer HTTP requests until SIGTERM or SIGINT");
  add_serve(serve_command, serve_options);

  BakeOptions bake_options;
  bake_options.service.formats = FormatSet::all();  // the file is the caller's own
  CLI::App& bake_command =
      *app.add_subcommand("bake", "Fracture one file: the same bytes as the server's answer");
  add_bake(bake_command, bake_options);

  InspectOptions inspect_options;
  inspect_options.service.formats = FormatSet::all();
  CLI::App& inspect_command =
      *app.add_subcommand("inspect",
                          "Say what a mesh is worth without fracturing it. Exits with 0: a closed solid as "
                          "it is, 1: usable after "
                          "repair, 2: refused, 3: wrong command line or unreadable file");
  add_inspect(inspect_command, inspect_options);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    constexpr int kInspectUsage = 3;
    return app.exit(e) == 0 ? kExitDone : inspect_command.parsed() ? kInspectUsage : kExitUsage;
  }
  if (inspect_command.parsed()) return inspect(inspect_options);
  return serve_command.parsed() ? serve(serve_options) : bake(bake_options);
}

}  // namespace fracture::cli
