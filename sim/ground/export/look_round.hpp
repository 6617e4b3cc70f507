// Decodes every keyframe once, writes its pictures and keeps its look.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <map>

#include "sim/ground/intake/catalogue.hpp"
#include "sim/ground/map/keyframe_look.hpp"

namespace ilp::exports {

/// Writes the files of export_keyframe into `folder` for what has changed since the last run, or is not there. Products
/// that do not decode have their fault in the look. All cores are used.
[[nodiscard]] std::map<std::int64_t, map::KeyframeLook> look_round(const intake::Flight& flight,
                                                                   const std::filesystem::path& folder,
                                                                   intake::Catalogue& catalogue,
                                                                   std::ostream& messages);

}  // namespace ilp::exports
