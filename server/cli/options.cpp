#include "server/cli/options.hpp"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <map>

#include "common/base/nearest_name.hpp"
#include "common/base/printed_output.hpp"
#include "common/parameters/groups.hpp"
#include "common/pipeline/algorithm_version.hpp"
#include "server/cli/command_line_words.hpp"
#include "server/cli/help.hpp"
#include "server/cli/program.hpp"
#include "server/cli/serve_settings.hpp"
#include "server/cli/spelling.hpp"

namespace fracture::cli {
namespace {

/// Options of `serve` that are not settings.
struct ServeCommand {
  std::string config_file;
  bool print_config = false;
};

/// Adds the flags of `serve` from the table of settings. Values are stored as text and validated later,
/// together with those from the environment and the config file.
void add_serve(CLI::App& app, std::vector<Setting>& settings, GivenSettings& flags, ServeCommand& command) {
  app.add_option("--config", command.config_file, "Read settings from this file (TOML: name = value)")
      ->type_name("FILE");
  app.add_flag("--print-config", command.print_config,
               "Print a config file with the given settings, and with all others commented out; then exit");
  std::map<std::string, CLI::Option_group*> groups;
  for (const Setting& setting : settings) {
    CLI::Option_group*& group = groups[setting.group];
    if (!group) group = app.add_option_group(setting.group);
    const std::string flag = "--" + setting.name;
    const auto take = [&flags, name = setting.name, flag](const std::string& value) {
      flags[name] = {value, flag};
    };
    if (setting.kind == Setting::Kind::kFlag) {
      group->add_flag_function(
          flag, [take](std::int64_t count) { take(count > 0 ? "true" : "false"); }, setting.doc);
    } else if (setting.kind == Setting::Kind::kList) {
      group
          ->add_option_function<std::vector<std::string>>(
              flag,
              [take](const std::vector<std::string>& values) {
                std::string joined;
                for (const std::string& value : values) joined += (joined.empty() ? "" : ",") + value;
                take(joined);
              },
              setting.doc)
          ->allow_extra_args(false)
          ->type_name(setting.type)
          ->default_str(setting.get());
    } else {
      group->add_option_function<std::string>(flag, take, setting.doc)
          ->type_name(setting.type)
          ->default_str(setting.get());
    }
  }
  app.footer(
      "Each setting can also be an environment variable (FRACTURE_MAX_BODY for --max-body) or a line in the "
      "--config file. A flag overrides the variable, and the variable overrides the file.\n\n" +
      std::string(kExitCodesInWords));
}

void add_parameter(CLI::App& app, std::vector<RawParameter>& parameters, const ParameterSpec& spec,
                   const std::string& heading) {
  app.add_option_function<std::string>(
         both_spellings(spec.name),
         [&parameters, name = spec.name](const std::string& value) {
           parameters.push_back({name, value, true});
         },
         values_of(spec) +
             (spec.name == "format" ? "Mesh format, if the file name does not show it" : spec.doc))
      ->group(heading)
      ->type_name(placeholder_of(spec));
}

/// Adds the parameters as text options, under the headings of the documents. The service's table validates them, as it does for HTTP
/// requests.
void add_parameters(CLI::App& app, std::vector<RawParameter>& parameters, const ServiceConfig& service) {
  const ParameterTable table(service.max_sites, FormatSet::all());
  for (const ParameterGroup& group : parameter_groups())
    for (const GroupedParameter& row : group.parameters)
      if (const ParameterSpec* spec = table.find(row.name))
        add_parameter(app, parameters, *spec, "Parameters: " + std::string(group.title));
}

void add_threads(CLI::App& app, int& threads, const char* doc, const char* heading) {
  app.add_option("--threads", threads, doc)
      ->check(in_range(0, 1024))
      ->type_name("N")
      ->capture_default_str()
      ->group(heading);
}

/// Adds an option for a number of bytes, with an optional suffix KiB, MiB or GiB.
void add_bytes(CLI::App& app, const char* name, std::uint64_t& bytes, const char* doc, const char* heading) {
  app.add_option_function<std::string>(
         name,
         [name, &bytes](const std::string& text) {
           constexpr std::uint64_t kLow = 1u << 20, kHigh = 1ull << 50;
           const std::optional<std::uint64_t> given = detail::parse_number(text, true, kLow, kHigh);
           if (!given)
             throw CLI::ValidationError(name,
                                        detail::requirement(true, kLow, kHigh) + "; it was '" + text + "'");
           bytes = *given;
         },
         doc)
      ->type_name("BYTES")
      ->group(heading);
}

/// Validator: an empty value usually comes from an unset variable in a script, so it is an error.
std::string not_empty(const std::string& text) { return text.empty() ? "the name must not be empty" : ""; }

Insertion insertion_of(const std::string& value) {
  if (value == "cavity") return Insertion::kCavity;
  if (value == "flips") return Insertion::kFlips;
  const std::vector<std::string> choices{"cavity", "flips"};
  const std::optional<std::string> meant = nearest_name(value, choices);
  throw CLI::ValidationError("--insertion", "must be cavity or flips; it was '" + value + "'" +
                                                (meant ? ". Did you mean '" + *meant + "'?" : ""));
}

void add_bake(CLI::App& app, BakeOptions& o) {
  constexpr const char *kFilesGroup = "Files", *kWorkGroup = "Many meshes",
                       *kSayGroup = "Messages and failures";
  app.add_option("input", o.source.inputs,
                 "Mesh files, folders (with their subfolders), or globs in quotes; - is standard input")
      ->type_name("");
  app.add_option(
         "-o,--output", o.source.output,
         "For one mesh: the file to write, as GLB (.glb or no extension), glTF (.gltf, a single JSON document), "
         "OBJ (.obj, with .mtl and textures), PLY or STL; the last three contain only geometry and appearance. "
         "- is standard output. For several meshes: a folder, in which sub/barrel.obj becomes sub/barrel.obj.glb")
      ->type_name("PATH")
      ->group(kFilesGroup);
  app.add_option("--manifest", o.source.manifest,
                 "Instead of input and --output: a file with one {\"input\": ..., \"output\": ..., "
                 "\"parameters\": {...}} per line; paths are relative to the file")
      ->type_name("FILE")
      ->check(not_empty)
      ->group(kFilesGroup);
  app.add_option(
         "--rules", o.source.rules,
         "JSON file that sets parameters for meshes by path, node or material: {\"rules\": [{\"match\": "
         "{\"path\": \"*_glass*\"}, \"parameters\": {\"material\": \"glass\"}}, ...]}. The first rule "
         "that matches applies. The rule overrides the command line; a manifest line overrides the rule")
      ->type_name("FILE")
      ->check(not_empty)
      ->group(kFilesGroup);
  app.add_flag(
         "--explain", o.explain,
         "Only print, for each mesh, the rules that match, why they match, and the resulting parameters")
      ->group(kFilesGroup);
  app.add_option("-j,--jobs", o.jobs, "Meshes computed at the same time; 0: one per core, or 8 with --server")
      ->check(in_range(0, 1024))
      ->type_name("N")
      ->capture_default_str()
      ->group(kWorkGroup);
  add_threads(app, o.threads,
              "Threads for a single mesh; 0: one per core. Several meshes use one thread each", kWorkGroup);
  add_bytes(app, "--memory", o.memory,
            "Memory for all meshes computed at the same time, divided evenly among -j meshes; default: three "
            "quarters of the memory of this machine or its control group",
            kWorkGroup);
  app.add_option("--shard", o.shard,
                 "I/N: bake every N-th mesh, starting with mesh I (0 to N - 1); auto/N: take I from "
                 "FRACTURE_SHARD, JOB_COMPLETION_INDEX or SLURM_ARRAY_TASK_ID")
      ->type_name("I/N")
      ->group(kWorkGroup);
  app.add_option(
         "--report", o.source.report,
         "Write a report with one JSON line per mesh to this file; the next run keeps the outputs that "
         "still match the report. Default: bake.ndjson in the output folder, or MANIFEST.report")
      ->type_name("FILE")
      ->check(not_empty)
      ->group(kWorkGroup);
  app.add_flag("--force", o.force, "Make all outputs again, even those that are up to date")
      ->group(kWorkGroup);
  app.add_option("--allow-refused", o.allow_refused, "Exit with 0 if at most this many meshes were refused")
      ->check(in_range(0, 1'000'000'000))
      ->type_name("N")
      ->capture_default_str()
      ->group(kWorkGroup);
  app.add_option("--depfile", o.source.depfile,
                 "For one mesh: write a make or Ninja rule that lists the files from which the output "
                 "was made")
      ->type_name("FILE")
      ->check(not_empty)
      ->group(kFilesGroup);
  app.add_option(
         "--keep-failures", o.source.failures,
         "Save to this folder all failures caused by bugs in this program, and all results that fail their "
         "check, each with the mesh, parameters, versions and a command that reproduces it. Limits: 100 "
         "failures and 1 GiB")
      ->type_name("FOLDER")
      ->check(not_empty)
      ->group(kSayGroup);
  app.add_flag("-q,--quiet", o.quiet, "Print no progress, notes or summary")->group(kSayGroup);

  constexpr const char* kLookGroup = "Pictures of the results, drawn by the client's fracture-render";
  app.add_option("--preview", o.source.preview,
                 "Draw the fragments, moved a little apart. For one mesh: a PNG file. For several meshes: a "
                 "folder, in which sub/barrel.obj.glb becomes sub/barrel.obj.glb.png. Only missing and "
                 "outdated pictures are drawn")
      ->type_name("PATH")
      ->group(kLookGroup);
  app.add_option(
         "--html", o.source.html,
         "Write an HTML page about all meshes, slowest first, with refusals and their reasons. If "
         "fracture-render is found, the page has pictures, stored in the --preview folder (default: FILE with the "
         "extension .pictures)")
      ->type_name("FILE")
      ->group(kLookGroup);
  app.add_option("--preview-size", o.preview_size,
                 "Width and height in pixels; default: 512 for one mesh, 256 for several")
      ->check(in_range(64, 2048))
      ->type_name("N")
      ->group(kLookGroup);
  app.add_option("--preview-timeout", o.preview_timeout_s, "Time limit for one picture, in seconds")
      ->check(in_range(1, 3600))
      ->type_name("S")
      ->capture_default_str()
      ->group(kLookGroup);
  app.add_option(
         "--renderer", o.renderer,
         "Path of fracture-render; default: next to this program, in the client's folder of the build tree, "
         "or in PATH")
      ->type_name("FILE")
      ->group(kLookGroup);

  constexpr const char* kWatchGroup = "Flags for examining the algorithm; they do not change the output";
  app.add_option_function<std::string>(
         "--insertion", [&o](const std::string& value) { o.insertion = insertion_of(value); },
         "How sites are inserted into the Delaunay tetrahedralization: by cavities, or by flips as in "
         "the source paper (the number of flips is then printed)")
      ->type_name("cavity|flips")
      ->default_str("cavity")
      ->group(kWatchGroup);
  app.add_option(
         "--dump-stages", o.source.stages,
         "Write the result of each stage (mesh, solid, sites, tetrahedra, fragments moved apart) as OBJ to this "
         "folder, without overwriting any file. Needs exactly one mesh; works even if its output is up to date")
      ->type_name("FOLDER")
      ->group(kWatchGroup)
      ->check(not_empty);

  constexpr const char* kServerGroup =
      "Flags for baking on a server, or on several behind a proxy; the files and the report are the same";
  app.add_option("--server", o.server, "http://host:port or https://host:port")
      ->type_name("URL")
      ->group(kServerGroup)
      ->check(not_empty);
  app.add_option(
         "--ca-file", o.ca_file,
         "Certificate authorities to trust for an https server (PEM); default: those that this system "
         "trusts")
      ->type_name("FILE")
      ->group(kServerGroup);
  app.add_option("--token", o.token,
                 "Token for the server; prefer the environment variable, because process lists show flags")
      ->type_name("TOKEN")
      ->envname("FRACTURE_TOKEN")
      ->group(kServerGroup);
  app.add_option("--patience", o.patience_s,
                 "Seconds for which the server may be unreachable or busy before the bake stops")
      ->check(in_range(0, 86400))
      ->type_name("S")
      ->capture_default_str()
      ->group(kServerGroup);
  add_parameters(app, o.source.parameters, o.service);
  app.footer(
      "fracture-server bake barrel.obj -o fragments.glb --sites 80 --material wood\n"
      "fracture-server bake assets/ -o broken/ -j 8\n"
      "fracture-server bake --manifest night.ndjson --shard 3/16\n"
      "fracture-server bake assets/ -o broken/ --html broken.html\n"
      "curl --fail https://example.org/barrel.glb | fracture-server bake - -o - > fragments.glb\n\n" +
      std::string(kExitCodesInWords) +
      " bake exits with 3 if more meshes than --allow-refused were refused. After exit code 130, the "
      "finished files are kept; run the same command again to continue. Parameter names can be written with - "
      "or _.");
}

void add_inspect(CLI::App& app, InspectOptions& o) {
  app.add_option(
         "input", o.inputs,
         "Mesh files, folders (with their subfolders), or globs in quotes; - is standard input. For one file, "
         "inspect prints a report; otherwise, a line for each mesh and a summary by cause")
      ->type_name("");
  app.add_flag(
      "--json", o.json,
      "Print the report as JSON; for several meshes: one line per mesh, then a line with the summary");
  add_bytes(app, "--memory", o.memory,
            "Memory for one mesh; default: three quarters of the memory of this machine or its control group",
            "Options");
  add_threads(app, o.threads, "Computing threads; 0: one per core", "Options");
  add_parameters(app, o.parameters, o.service);
  app.footer(kExitCodesInWords);
}

void add_health(CLI::App& app, HealthOptions& o) {
  app.add_option("url", o.url,
                 "http://host[:port][/path]; default: this machine's admin listener, as set by the "
                 "environment and --config");
  app.add_option("--config", o.config_file, "The server's config file")->type_name("FILE");
  app.add_flag("--ready", o.ready,
               "Ask whether the server accepts requests (/readyz), not whether it is running (/livez)");
  app.add_option("--timeout", o.timeout, "Seconds to wait for the connection, and again for the response")
      ->check(in_range(1, 3600))
      ->capture_default_str();
  app.footer(kExitCodesInWords);
}

}  // namespace

int run(int argc, char** argv) {
  CLI::App app("Exact, watertight mesh fracture: as a server (serve) or for files (bake).",
               "fracture-server");
  app.formatter(help_formatter());
  app.failure_message(words_of_failure);
  app.set_version_flag("--version",
                       "fracture-server " FRACTURE_VERSION " algorithm " + std::to_string(kAlgorithmVersion));
  app.require_subcommand(1);

  // Add options only to the command that is given: adding all two hundred takes longer than the cuts of a
  // small bake.
  ServeOptions serve_options;
  serve_options.drain_delay = std::chrono::milliseconds(::isatty(STDERR_FILENO) ? 0 : 5'000);
  std::vector<Setting> settings;
  GivenSettings flags;
  ServeCommand command;
  CLI::App& serve_command = *app.add_subcommand("serve", "Answer HTTP requests until SIGTERM or SIGINT");
  serve_command.preparse_callback([&](std::size_t) {
    settings = serve_settings(serve_options);
    add_serve(serve_command, settings, flags, command);
  });

  BakeOptions bake_options;
  bake_options.service.formats = FormatSet::all();  // all formats, because users bake their own files
  CLI::App& bake_command =
      *app.add_subcommand("bake", "Fracture files; the outputs have the same bytes as a server's answers");
  bake_command.preparse_callback([&](std::size_t) { add_bake(bake_command, bake_options); });

  InspectOptions inspect_options;
  inspect_options.service.formats = FormatSet::all();
  CLI::App& inspect_command =
      *app.add_subcommand("inspect", "Report whether a mesh can be fractured, in words and by the exit code");
  inspect_command.preparse_callback([&](std::size_t) { add_inspect(inspect_command, inspect_options); });

  HealthOptions health_options;
  CLI::App& health_command = *app.add_subcommand(
      "health", "Ask a server whether it is healthy, and report the result in words and by the exit code");
  health_command.preparse_callback([&](std::size_t) { add_health(health_command, health_options); });

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    const std::optional<std::string> unknown = e.get_exit_code() == 0 ? std::nullopt : unknown_word(app);
    if (unknown) {
      const std::vector<CLI::App*> commands = app.get_subcommands();
      const std::string program =
          "fracture-server" + (commands.empty() ? "" : " " + commands.front()->get_name());
      std::fprintf(stderr, "%s: %s\nRun %s --help for a list.\n", program.c_str(), unknown->c_str(),
                   program.c_str());
    } else if (app.exit(e) == 0) {
      flush_printed();
      return kExitDone;
    }
    return kExitUsage;
  }
  if (inspect_command.parsed()) return inspect(inspect_options);
  if (bake_command.parsed()) return bake(bake_options);
  if (health_command.parsed()) return health(health_options);

  GivenSettings given;
  const std::vector<std::string> errors =
      configure(serve_options, settings, flags, command.config_file, &given);
  for (const std::string& error : errors) std::fprintf(stderr, "fracture-server: %s\n", error.c_str());
  if (!errors.empty()) return kExitUsage;
  if (command.print_config) {
    std::fputs(to_config_file(settings, given).c_str(), stdout);
    flush_printed();
    return kExitDone;
  }
  serve_options.configuration = to_json(settings);
  return serve(serve_options);
}

}  // namespace fracture::cli
