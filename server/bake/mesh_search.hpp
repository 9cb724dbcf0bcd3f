// Finds meshes in files, folders and globs.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "server/bake/output_path.hpp"

namespace fracture::bake {

/// A mesh found in an input, and its path below that input, by which its output is named.
struct FoundMesh {
  std::string path;
  std::filesystem::path name;
};

/// The reason why a link of MeshSearch::dangling() cannot be read.
inline constexpr const char* kDangling = "the link's target does not exist";

/// Whether an input stands for several files: it is a folder, or a glob that is not the name of a file.
bool stands_for_many(const std::string& input);

/// Searches inputs for meshes and leaves out the results of earlier bakes.
///
/// A folder includes the folders below it. Links to folders are followed after the folders that are not links, in the
/// order of their paths. Each folder is searched only once, and folders around the input are not searched, so the search
/// ends even if links form loops. Folders are identified by device and inode.
///
/// A link without a target is found like a mesh if it has the name of a mesh, because reading the mesh then reports the
/// reason. Other links without a target are in dangling().
class MeshSearch {
 public:
  /// Adds the results that the report of an earlier bake lists. Reports named "bake.*.ndjson" in the folders are found.
  void add_report(const std::string& report);
  /// Excludes a folder.
  void leave_out(const std::string& folder) { left_out_.insert(identity_of(folder)); }

  /// Searches one input: a folder, a glob or a file. Returns kBadParameter if it contains no mesh, or if a folder cannot
  /// be read.
  Expected<void> look_into(const std::string& input);

  /// The meshes found so far, in the order of their paths.
  std::vector<FoundMesh> found() const;
  const std::vector<std::string>& skipped() const { return skipped_; }    ///< results of earlier bakes
  const std::vector<std::string>& dangling() const { return dangling_; }  ///< links without a target

 private:
  Expected<void> look_into_folder(const std::string& folder);
  Expected<void> look_into_one(const std::string& folder);
  void look_into_glob(const std::string& pattern);
  void add(FoundMesh mesh);

  std::set<FileIdentity> results_;  ///< by the reports of earlier bakes
  std::set<FileIdentity> left_out_;
  std::vector<FoundMesh> found_;
  std::vector<std::string> skipped_, dangling_;

  /// The state of look_into_folder().
  std::set<FileIdentity> searched_;
  std::vector<std::string> folders_, links_;  ///< still to be searched
  std::vector<FoundMesh> meshes_;
  std::string root_;
};

}  // namespace fracture::bake
