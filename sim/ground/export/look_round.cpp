#include "sim/ground/export/look_round.hpp"

#include <mutex>

#include "sim/ground/export/export_files.hpp"
#include "sim/ground/intake/keyframe_rasters.hpp"
#include "sim/host/files.hpp"
#include "sim/host/parallel.hpp"
#include "sim/host/progress.hpp"

namespace ilp::ground {
namespace {

struct LookRound {
  const std::filesystem::path& folder;
  Catalogue& catalogue;
  std::int32_t width_px;

  KeyframeLook look(const Keyframe& keyframe) {
    const std::uint64_t digest = keyframe_digest(keyframe) ^ static_cast<std::uint64_t>(width_px);
    if (const auto bytes = catalogue.look(keyframe.id, digest); bytes && keyframe_is_exported(keyframe, folder)) {
      if (auto known = look_from(*bytes)) return *known;
    }
    thread_local PixelRays rays;
    const DecodedProducts decoded = decode_products(keyframe);
    export_keyframe(keyframe.id, decoded.rasters, folder);
    KeyframeLook look = look_at(keyframe, decoded.rasters, width_px, rays);
    look.faults = decoded.faults;
    catalogue.put_look(keyframe.id, digest, bytes_of(look));
    return look;
  }
};

}  // namespace

std::map<std::int64_t, KeyframeLook> look_round(const Flight& flight, const std::filesystem::path& folder,
                                                Catalogue& catalogue, std::ostream& messages) {
  if (!flight.keyframes.empty()) make_output_folder(folder);
  std::vector<const Keyframe*> keyframes;
  for (const auto& [id, keyframe] : flight.keyframes) keyframes.push_back(&keyframe);
  std::vector<KeyframeLook> looks(keyframes.size());
  LookRound round{folder, catalogue, look_width_px(keyframes.size())};
  Progress progress(messages, "decoding keyframes");
  std::mutex mutex;
  std::size_t done = 0;
  sim::for_each_parallel(keyframes.size(), [&](std::size_t i) {
    looks[i] = round.look(*keyframes[i]);
    const std::lock_guard lock(mutex);
    progress(++done, keyframes.size());
  });
  std::map<std::int64_t, KeyframeLook> by_id;
  for (std::size_t i = 0; i < keyframes.size(); ++i) by_id.emplace(keyframes[i]->id, std::move(looks[i]));
  return by_id;
}

}  // namespace ilp::ground
