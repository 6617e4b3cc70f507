#include "sim/ground/export/look_round.hpp"

#include <mutex>

#include "sim/ground/export/strip_exports.hpp"
#include "sim/ground/intake/keyframe_rasters.hpp"
#include "sim/host/files.hpp"
#include "sim/host/parallel.hpp"
#include "sim/host/progress.hpp"

namespace ilp::exports {
namespace {

struct LookRound {
  const std::filesystem::path& folder;
  intake::Catalogue& catalogue;
  std::int32_t width_px;

  map::KeyframeLook look(const intake::Keyframe& keyframe) {
    const std::uint64_t digest = map::keyframe_digest(keyframe) ^ static_cast<std::uint64_t>(width_px);
    if (const auto bytes = catalogue.look(keyframe.id, digest); bytes && keyframe_is_exported(keyframe, folder)) {
      if (auto known = map::look_from(*bytes)) return *known;
    }
    thread_local map::PixelRays rays;
    const intake::DecodedProducts decoded = intake::decode_products(keyframe);
    export_keyframe(keyframe.id, decoded.rasters, folder);
    map::KeyframeLook look = map::look_at(keyframe, decoded.rasters, width_px, rays);
    look.faults = decoded.faults;
    catalogue.put_look(keyframe.id, digest, map::bytes_of(look));
    return look;
  }
};

}  // namespace

std::map<std::int64_t, map::KeyframeLook> look_round(const intake::Flight& flight, const std::filesystem::path& folder,
                                                     intake::Catalogue& catalogue, std::ostream& messages) {
  if (!flight.keyframes.empty()) host::make_output_folder(folder);
  std::vector<const intake::Keyframe*> keyframes;
  for (const auto& [id, keyframe] : flight.keyframes) keyframes.push_back(&keyframe);
  std::vector<map::KeyframeLook> looks(keyframes.size());
  LookRound round{folder, catalogue, map::look_width_px(keyframes.size())};
  host::Progress progress(messages, "decoding keyframes");
  std::mutex mutex;
  std::size_t done = 0;
  host::for_each_parallel(keyframes.size(), [&](std::size_t i) {
    looks[i] = round.look(*keyframes[i]);
    const std::lock_guard lock(mutex);
    progress(++done, keyframes.size());
  });
  std::map<std::int64_t, map::KeyframeLook> by_id;
  for (std::size_t i = 0; i < keyframes.size(); ++i) by_id.emplace(keyframes[i]->id, std::move(looks[i]));
  return by_id;
}

}  // namespace ilp::exports
