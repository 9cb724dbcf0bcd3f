// Where the pictures of a bake go (--preview), and its page (--html).
#pragma once

#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "server/bake/plan.hpp"

namespace fracture::bake {

/// Gives every job its picture, where some are wanted: for one mesh the PNG that --preview names; for many, below the folder
/// that it names, what their outputs are called below theirs, with .png behind it (out/sub/barrel.obj.glb becomes
/// FOLDER/sub/barrel.obj.glb.png). The folder of the outputs is that of --output, or of the manifest; a ".." on the way out of it is
/// called "up". With --html alone the folder is night.pictures beside night.html. kBadParameter where --preview cannot be
/// that.
Expected<void> give_pictures(const BakeSource& source, bool single, std::vector<BakeJob>& jobs);

/// One page for each shard: night.3-of-16.html.
std::string page_of(const BakeSource& source);

/// ".3-of-16", empty where there is one shard.
std::string part_of(const Shard& shard);

}  // namespace fracture::bake
