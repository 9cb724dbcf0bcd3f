// Rules of a bake: parameters for the meshes whose path, nodes or materials are called so.
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

/// Patterns are those of a shell (name_pattern.hpp): `*` is any text, '/' included, `?` one character, `[a-z]` one of
/// these, a backslash takes the next as it is. One that no list has asks for nothing; of a list one has to match, and
/// of several lists each.
struct Rule {
  std::vector<std::string> paths{};      ///< the path of the input, or an end of it that begins behind a '/'
  std::vector<std::string> nodes{};      ///< the whole name of any of the mesh's
  std::vector<std::string> materials{};  ///< the same
  std::vector<RawParameter> parameters{};
};

struct RuleFile {
  std::string path{};  ///< empty: there are no rules
  std::vector<Rule> rules{};
  /// Does any rule ask for what only the bytes of a mesh say?
  bool by_names() const;
};

constexpr std::size_t kMaxRuleFileBytes = 1u << 20;
constexpr std::size_t kMaxRules = 1000;
constexpr std::size_t kMaxPatternsOfRule = 100;  ///< of one list
constexpr std::size_t kMaxPatternBytes = 1000;
/// Comparisons of a byte for one mesh, about a second of them: 20,000 names with all of 1,000 patterns that end with an
/// asterisk take a third.
constexpr std::size_t kMaxMatchSteps = 200'000'000;

/// kBadParameter, which names the file, the line or rule, and the limit.
Expected<RuleFile> read_rules(const std::string& path);

/// Those of `over` replace those of the same name.
void put_over(const std::vector<RawParameter>& over, std::vector<RawParameter>& parameters);

/// Checks the parameters of a request by the table of a baker.
using ParseParameters = std::function<Expected<RequestParameters>(const std::vector<RawParameter>&)>;

/// kBadParameter or kUnknownParameter, which names the rule, where one's parameters are not right together with those of
/// the command line.
Expected<void> check_rules(const RuleFile& file, const std::vector<RawParameter>& command_line,
                           const ParseParameters& parse);

struct RuleMatch {
  std::size_t rule;  ///< index
  std::string why;   ///< "path '*_glass*' matches, material 'oak*' matches 'oak_dark'"
};

/// Finds the rule of each mesh, and which rules are of no use for all of them. Thread-safe: no mesh waits for another's.
class RuleTally {
 public:
  explicit RuleTally(const RuleFile& file) : file_(file), seen_(file.rules.size()) {}
  /// The first that matches decides; nothing: none does. kTooLarge: more than kMaxMatchSteps; kCancelled: the stop came.
  Expected<std::optional<RuleMatch>> find(const std::string& path, const MeshNames& names,
                                          const std::stop_token& stop = {});
  /// A mesh whose names are not known: no rule that they might have matched is said to be of no use.
  void add_unread(const std::string& path);
  /// One sentence for each rule that matched no mesh, or only such as an earlier rule decides.
  std::vector<std::string> warnings() const;

 private:
  struct Seen {
    std::atomic<bool> matched{false}, decided{false};
  };
  const RuleFile& file_;
  std::vector<Seen> seen_;
};

}  // namespace fracture::bake
