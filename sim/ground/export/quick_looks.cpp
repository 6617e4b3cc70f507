#include "sim/ground/export/quick_looks.hpp"

#include <mutex>
#include <stdexcept>

#include "sim/ground/export/strip_exports.hpp"
#include "sim/ground/intake/keyframe_rasters.hpp"
#include "sim/ground/map/damaged_catalogue.hpp"
#include "sim/host/files.hpp"
#include "sim/host/parallel.hpp"
#include "sim/host/progress.hpp"

namespace ilp::exports {
namespace {

std::optional<map::KeyframeQuickLook> known_quick_look(const intake::Keyframe& keyframe, std::uint64_t digest,
                                                       const std::filesystem::path& folder,
                                                       intake::Catalogue& catalogue) {
  const auto bytes = catalogue.quick_look(keyframe.id, digest);
  return bytes && keyframe_is_exported(keyframe, folder) ? map::quick_look_from(*bytes) : std::nullopt;
}

}  // namespace

std::uint64_t quick_look_digest(const intake::Keyframe& keyframe, std::int32_t width_px) {
  return map::keyframe_digest(keyframe) ^ static_cast<std::uint64_t>(width_px);
}

map::KeyframeQuickLook quick_look_and_export(const intake::Keyframe& keyframe, std::int32_t width_px,
                                             const std::filesystem::path& folder) {
  thread_local map::PixelRays rays;
  const intake::DecodedProducts decoded = intake::decode_products(keyframe);
  export_keyframe(keyframe.id, decoded.rasters, folder);
  map::KeyframeQuickLook quick_look = map::quick_look_at(keyframe, decoded.rasters, width_px, rays);
  quick_look.faults = decoded.faults;
  return quick_look;
}

map::KeyframeQuickLook known_quick_look(const intake::Flight& flight, std::int64_t id,
                                        const map::KeyframeQuickLook& quick_look, intake::Catalogue& catalogue) {
  const std::int32_t width_px = map::quick_look_width_px(flight.keyframes.size());
  const auto bytes = catalogue.quick_look(id, quick_look.digest ^ static_cast<std::uint64_t>(width_px));
  auto whole = bytes ? map::quick_look_from(*bytes) : std::nullopt;
  if (!whole) throw map::DamagedCatalogue("the quick-look of a keyframe cannot be read back");
  return std::move(*whole);
}

std::vector<std::int64_t> keyframes_without_quick_look(const intake::Flight& flight,
                                                       const std::filesystem::path& folder,
                                                       intake::Catalogue& catalogue) {
  const std::int32_t width_px = map::quick_look_width_px(flight.keyframes.size());
  std::vector<std::int64_t> ids;
  for (const auto& [id, keyframe] : flight.keyframes) {
    if (!known_quick_look(keyframe, quick_look_digest(keyframe, width_px), folder, catalogue)) ids.push_back(id);
  }
  return ids;
}

std::map<std::int64_t, map::KeyframeQuickLook> make_quick_looks(const intake::Flight& flight,
                                                                const std::filesystem::path& folder,
                                                                intake::Catalogue& catalogue, std::ostream& messages) {
  if (!flight.keyframes.empty()) host::make_output_folder(folder);
  std::vector<const intake::Keyframe*> keyframes;
  for (const auto& [id, keyframe] : flight.keyframes) keyframes.push_back(&keyframe);
  std::vector<map::KeyframeQuickLook> quick_looks(keyframes.size());
  const std::int32_t width_px = map::quick_look_width_px(keyframes.size());
  host::Progress progress(messages, "Decoding keyframes");
  std::mutex mutex;
  std::size_t done = 0;
  host::for_each_parallel(keyframes.size(), [&](std::size_t i) {
    const std::uint64_t digest = quick_look_digest(*keyframes[i], width_px);
    if (auto known = known_quick_look(*keyframes[i], digest, folder, catalogue)) {
      quick_looks[i] = std::move(*known);
    } else {
      quick_looks[i] = quick_look_and_export(*keyframes[i], width_px, folder);
      catalogue.put_quick_look(keyframes[i]->id, digest, map::bytes_of(quick_looks[i]));
    }
    for (std::vector<std::uint8_t>* picture : {&quick_looks[i].image, &quick_looks[i].mask, &quick_looks[i].depth})
      *picture = {};
    const std::lock_guard lock(mutex);
    progress(++done, keyframes.size());
  });
  std::map<std::int64_t, map::KeyframeQuickLook> by_id;
  for (std::size_t i = 0; i < keyframes.size(); ++i) by_id.emplace(keyframes[i]->id, std::move(quick_looks[i]));
  return by_id;
}

}  // namespace ilp::exports
