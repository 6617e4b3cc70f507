// Decodes every keyframe once, writes its pictures, and keeps its quick-look in the catalogue.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <map>

#include "sim/ground/intake/catalogue.hpp"
#include "sim/ground/map/keyframe_quick_look.hpp"

namespace ilp::exports {

/// Returns the quick-looks of all keyframes, without pictures; key: keyframe id. Decodes keyframes that have changed
/// since the last run or whose files are missing, and writes the files of export_keyframe into `folder`. A product that
/// cannot be decoded has its fault in the quick-look. The pictures are in the catalogue (known_quick_look). Uses all
/// cores.
[[nodiscard]] std::map<std::int64_t, map::KeyframeQuickLook> make_quick_looks(const intake::Flight& flight,
                                                                              const std::filesystem::path& folder,
                                                                              intake::Catalogue& catalogue,
                                                                              std::ostream& messages);

/// A quick-look of make_quick_looks with its pictures, from the catalogue. Throws DamagedCatalogue if it is not there.
[[nodiscard]] map::KeyframeQuickLook known_quick_look(const intake::Flight& flight, std::int64_t id,
                                                      const map::KeyframeQuickLook& quick_look,
                                                      intake::Catalogue& catalogue);

// Parts of make_quick_looks, for several processes that share its work.

/// Key of a quick-look in the catalogue: digest of everything that it depends on, and of the width of its pictures.
[[nodiscard]] std::uint64_t quick_look_digest(const intake::Keyframe& keyframe, std::int32_t width_px);
/// Decodes a keyframe and writes its files of export_keyframe. Throws std::runtime_error if they cannot be written.
[[nodiscard]] map::KeyframeQuickLook quick_look_and_export(const intake::Keyframe& keyframe, std::int32_t width_px,
                                                           const std::filesystem::path& folder);
/// Ids of the keyframes that make_quick_looks would decode, ascending.
[[nodiscard]] std::vector<std::int64_t> keyframes_without_quick_look(const intake::Flight& flight,
                                                                     const std::filesystem::path& folder,
                                                                     intake::Catalogue& catalogue);

}  // namespace ilp::exports
