// Every keyframe decoded once: its pictures written, what is told of it kept.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <map>

#include "sim/ground/intake/catalogue.hpp"
#include "sim/ground/map/keyframe_look.hpp"

namespace ilp::ground {

/// Writes the files of export_keyframe into `folder` for what has changed since the last run, or is not there. Products
/// that do not decode have their fault in the look. Keyframes are looked at on all cores.
[[nodiscard]] std::map<std::int64_t, KeyframeLook> look_round(const Flight& flight, const std::filesystem::path& folder,
                                                              Catalogue& catalogue, std::ostream& messages);

}  // namespace ilp::ground
