// Rules of a bake: parameters for meshes whose path matches a pattern, and for the parts of a mesh whose node or material does.
//
//   {"rules": [{"match": {"path": "*_glass*"}, "parameters": {"material": "glass"}},
//              {"match": {"path": "props/*", "material": ["oak*", "pine*"]}, "parameters": {"material": "wood"}}]}
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/parameters/parameters.hpp"
#include "server/bake/mesh_names.hpp"

namespace fracture::bake {

/// Patterns are shell patterns (name_pattern.hpp): `*` is any text including '/', `?` one byte, `[a-z]` one
/// byte of a set, and a backslash makes the next byte literal. A rule matches if each non-empty list contains
/// a pattern that matches.
struct Rule {
  std::vector<std::string> paths{};      ///< the input's path, or its end after any '/'
  std::vector<std::string> nodes{};      ///< the whole name of a node, or of a node above it
  std::vector<std::string> materials{};  ///< the whole name of the material on most of a part's surface
  std::vector<RawParameter> parameters{};
  /// Whether it applies to the parts that match, not to the whole mesh.
  bool is_of_parts() const { return !nodes.empty() || !materials.empty(); }
};

struct RuleFile {
  std::string path{};  ///< empty: there are no rules
  std::vector<Rule> rules{};
  /// Returns whether any rule needs the names inside the meshes.
  bool by_names() const;
};

constexpr std::size_t kMaxRuleFileBytes = 1u << 20;
constexpr std::size_t kMaxRules = 1000;
constexpr std::size_t kMaxPatternsOfRule = 100;  ///< in each list
constexpr std::size_t kMaxPatternBytes = 1000;
/// Maximum number of byte comparisons for one mesh, about one second. Matching 20,000 names with all of 1,000
/// patterns that end with an asterisk takes a third of that.
constexpr std::size_t kMaxMatchSteps = 200'000'000;

/// Reads a rule file. Returns kBadParameter with the file, the line or rule, and the limit.
Expected<RuleFile> read_rules(const std::string& path);

/// Adds the parameters in `over` to `parameters`, replacing those with the same name.
void put_over(const std::vector<RawParameter>& over, std::vector<RawParameter>& parameters);

/// Checks the parameters of a request by a baker's table.
using ParseParameters = std::function<Expected<RequestParameters>(const std::vector<RawParameter>&)>;

/// Checks the parameters of each rule combined with the command line, as parameters_of() combines them (rule_parameters.hpp).
/// Returns kBadParameter or kUnknownParameter with the rule concerned.
Expected<void> check_rules(const RuleFile& file, const std::vector<RawParameter>& command_line,
                           const ParseParameters& parse);

struct RuleMatch {
  std::size_t rule;  ///< index
  std::string why;   ///< "path '*_glass*' matches, material 'oak*' matches 'oak_dark'"
};

/// Finds the rules for each mesh and records which rules are never used. Thread-safe; threads do not block
/// each other.
class RuleTally {
 public:
  explicit RuleTally(const RuleFile& file) : file_(file), seen_(file.rules.size()) {}
  /// Returns the rules that may decide a part of the mesh, in their order: all that match, up to the first one that applies to
  /// the whole mesh. Errors: kTooLarge if more than kMaxMatchSteps are needed, kCancelled if a stop is requested.
  Expected<std::vector<RuleMatch>> find(const std::string& path, const MeshNames& names,
                                        const std::stop_token& stop = {});
  /// Records a mesh whose names could not be read. Rules that these names might have matched are not reported
  /// as unused.
  void add_unread(const std::string& path);
  /// Returns one sentence for each rule that matched no mesh, or only meshes that an earlier rule decides.
  std::vector<std::string> warnings() const;

 private:
  struct Seen {
    std::atomic<bool> matched{false}, decided{false};
  };
  const RuleFile& file_;
  std::vector<Seen> seen_;
};

}  // namespace fracture::bake
