// Decodes every keyframe once, writes its pictures and keeps its quick-look.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <map>

#include "sim/ground/intake/catalogue.hpp"
#include "sim/ground/map/keyframe_quick_look.hpp"

namespace ilp::exports {

/// Writes the files of export_keyframe into `folder` for what has changed since the last run, or is not there. Products
/// that do not decode have their fault in the quick-look. Pictures stay in the catalogue (known_quick_look). All cores
/// are used.
[[nodiscard]] std::map<std::int64_t, map::KeyframeQuickLook> make_quick_looks(const intake::Flight& flight,
                                                                              const std::filesystem::path& folder,
                                                                              intake::Catalogue& catalogue,
                                                                              std::ostream& messages);

/// What make_quick_looks gave as `quick_look`, with its pictures. Throws std::runtime_error when the catalogue does not
/// hold it.
[[nodiscard]] map::KeyframeQuickLook known_quick_look(const intake::Flight& flight, std::int64_t id,
                                                      const map::KeyframeQuickLook& quick_look,
                                                      intake::Catalogue& catalogue);

// The parts of the round, for processes that do it together.

/// What the catalogue keeps a quick-look under: digest of all that it depends on, with the width of its pictures.
[[nodiscard]] std::uint64_t quick_look_digest(const intake::Keyframe& keyframe, std::int32_t width_px);
/// Decodes the keyframe and writes its files of export_keyframe. Throws std::runtime_error when they cannot be written.
[[nodiscard]] map::KeyframeQuickLook quick_look_and_export(const intake::Keyframe& keyframe, std::int32_t width_px,
                                                           const std::filesystem::path& folder);
/// The keyframes that a round would decode, by id.
[[nodiscard]] std::vector<std::int64_t> keyframes_without_quick_look(const intake::Flight& flight,
                                                                     const std::filesystem::path& folder,
                                                                     intake::Catalogue& catalogue);

}  // namespace ilp::exports
