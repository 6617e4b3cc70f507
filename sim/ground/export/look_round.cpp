#include "sim/ground/export/look_round.hpp"

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

std::optional<map::KeyframeLook> known_look(const intake::Keyframe& keyframe, std::uint64_t digest,
                                            const std::filesystem::path& folder, intake::Catalogue& catalogue) {
  const auto bytes = catalogue.look(keyframe.id, digest);
  return bytes && keyframe_is_exported(keyframe, folder) ? map::look_from(*bytes) : std::nullopt;
}

}  // namespace

std::uint64_t look_digest(const intake::Keyframe& keyframe, std::int32_t width_px) {
  return map::keyframe_digest(keyframe) ^ static_cast<std::uint64_t>(width_px);
}

map::KeyframeLook look_and_export(const intake::Keyframe& keyframe, std::int32_t width_px,
                                  const std::filesystem::path& folder) {
  thread_local map::PixelRays rays;
  const intake::DecodedProducts decoded = intake::decode_products(keyframe);
  export_keyframe(keyframe.id, decoded.rasters, folder);
  map::KeyframeLook look = map::look_at(keyframe, decoded.rasters, width_px, rays);
  look.faults = decoded.faults;
  return look;
}

map::KeyframeLook known_look(const intake::Flight& flight, std::int64_t id, const map::KeyframeLook& look,
                             intake::Catalogue& catalogue) {
  const std::int32_t width_px = map::look_width_px(flight.keyframes.size());
  const auto bytes = catalogue.look(id, look.digest ^ static_cast<std::uint64_t>(width_px));
  auto whole = bytes ? map::look_from(*bytes) : std::nullopt;
  if (!whole) throw map::DamagedCatalogue("a look at a keyframe cannot be read back");
  return std::move(*whole);
}

std::vector<std::int64_t> keyframes_without_look(const intake::Flight& flight, const std::filesystem::path& folder,
                                                 intake::Catalogue& catalogue) {
  const std::int32_t width_px = map::look_width_px(flight.keyframes.size());
  std::vector<std::int64_t> ids;
  for (const auto& [id, keyframe] : flight.keyframes) {
    if (!known_look(keyframe, look_digest(keyframe, width_px), folder, catalogue)) ids.push_back(id);
  }
  return ids;
}

std::map<std::int64_t, map::KeyframeLook> look_round(const intake::Flight& flight, const std::filesystem::path& folder,
                                                     intake::Catalogue& catalogue, std::ostream& messages) {
  if (!flight.keyframes.empty()) host::make_output_folder(folder);
  std::vector<const intake::Keyframe*> keyframes;
  for (const auto& [id, keyframe] : flight.keyframes) keyframes.push_back(&keyframe);
  std::vector<map::KeyframeLook> looks(keyframes.size());
  const std::int32_t width_px = map::look_width_px(keyframes.size());
  host::Progress progress(messages, "Decoding keyframes");
  std::mutex mutex;
  std::size_t done = 0;
  host::for_each_parallel(keyframes.size(), [&](std::size_t i) {
    const std::uint64_t digest = look_digest(*keyframes[i], width_px);
    if (auto known = known_look(*keyframes[i], digest, folder, catalogue)) {
      looks[i] = std::move(*known);
    } else {
      looks[i] = look_and_export(*keyframes[i], width_px, folder);
      catalogue.put_look(keyframes[i]->id, digest, map::bytes_of(looks[i]));
    }
    for (std::vector<std::uint8_t>* picture : {&looks[i].image, &looks[i].mask, &looks[i].depth}) *picture = {};
    const std::lock_guard lock(mutex);
    progress(++done, keyframes.size());
  });
  std::map<std::int64_t, map::KeyframeLook> by_id;
  for (std::size_t i = 0; i < keyframes.size(); ++i) by_id.emplace(keyframes[i]->id, std::move(looks[i]));
  return by_id;
}

}  // namespace ilp::exports
