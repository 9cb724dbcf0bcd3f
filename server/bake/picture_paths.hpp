// Paths of the pictures (--preview) and the HTML page (--html) of a bake.
#pragma once

#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "server/bake/plan.hpp"

namespace fracture::bake {

/// Sets the picture path of every job, if pictures are wanted. For one mesh, --preview names the PNG. For
/// many, it names a folder, and each picture has its output's path relative to the output folder, plus .png:
/// out/sub/barrel.obj.glb becomes FOLDER/sub/barrel.obj.glb.png. The output folder is that of --output, or of
/// the manifest; each ".." on the way out of it becomes "up". With --html alone, the pictures of night.html
/// are in night.pictures next to it. Returns kBadParameter if --preview cannot be used this way.
Expected<void> give_pictures(const BakeSource& source, bool single, std::vector<BakeJob>& jobs);

/// Returns the path of the HTML page; each shard has its own: night.3-of-16.html.
std::string page_of(const BakeSource& source);

/// Returns ".3-of-16", or an empty string if there is only one shard.
std::string part_of(const Shard& shard);

}  // namespace fracture::bake
