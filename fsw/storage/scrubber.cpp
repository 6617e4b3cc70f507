#include "fsw/storage/scrubber.hpp"

#include <algorithm>

namespace ilp {
namespace {

// Most bytes read at once, however long the last step is ago.
constexpr std::size_t most_image_bytes = std::size_t{1} << 20U;
constexpr std::size_t most_store_bytes = std::size_t{256} << 10U;
// The checksum of a region is computed in pieces of this size, however much a step may read.
constexpr std::size_t chunk_bytes = 4096;

std::uint64_t checksum_of(std::span<const std::byte> region) {
  std::uint64_t sum = 0;
  for (std::size_t at = 0; at < region.size(); at += chunk_bytes) {
    sum = checksum64(region.subspan(at, std::min(chunk_bytes, region.size() - at)), sum);
  }
  return sum;
}

}  // namespace

constexpr CheckpointForm Scrubber::checkpoint = checkpoint_form<State>(component_id);

Scrubber::Scrubber(Tables store, Clock& clock, const MissionParameters& mission, ImageRegions image)
    : wiring_{store, clock, mission, image.first(std::min(image.size(), most_regions))} {
  for (std::size_t i = 0; i < wiring_.image.size(); ++i) wiring_.image_sums[i] = checksum_of(wiring_.image[i]);
}

Status Scrubber::restore() {
  work_ = {};
  const Status loaded = restore_checkpoint(wiring_.store, checkpoint, cursor_, state_);
  // The position does not matter: reading starts over.
  return loaded.is(StatusCode::store_build) ? Status{} : loaded;
}

std::size_t Scrubber::grant(double bytes_per_s, TimeNs elapsed, std::size_t most) {
  const double bytes = bytes_per_s * 1e-9 * static_cast<double>(elapsed);
  return bytes < static_cast<double>(most) ? static_cast<std::size_t>(std::max(bytes, 0.0)) : most;
}

/// False if it is already known.
bool Scrubber::learn(const Damaged& damaged) {
  for (const Damaged& known : state_.damaged) {
    if (known.table == damaged.table && known.id == damaged.id) return false;
  }
  if (state_.damaged.full()) state_.damaged.erase(0);
  return state_.damaged.push_back(damaged);
}

Status Scrubber::save() {
  StepTransaction transaction(wiring_.store, checkpoint);
  ILP_TRY(transaction.begin());
  return transaction.commit(Cursor{cursor_.first + 1, 0}, state_, cursor_);
}

Status Scrubber::check_store(std::size_t bytes, TimeNs now) {
  if (bytes == 0) return {};
  // After a restart mission time may begin again.
  if (now < state_.begun_ns) state_.begun_ns = now;
  if (state_.resting && now - state_.begun_ns < ns_from_seconds(wiring_.mission.scrub_period_s)) return {};
  if (state_.resting) {
    state_.resting = false;
    state_.begun_ns = now;
  }
  const std::size_t table = state_.place.table;
  const ScrubSlice slice = scrub(wiring_.store, bytes, workspace_.scratch, state_.place);
  ILP_TRY(slice.fault);
  Status updates = slice.damage;
  if (slice.damage.is(StatusCode::record_damaged) && !learn({slice.damage.b, slice.damage.a})) updates = {};
  state_.resting = slice.round_complete;
  // Saved rarely: after a restart a slightly older position only repeats some reading.
  if (updates.ok() && table == state_.place.table && !slice.round_complete) return {};
  const Status saved = save();
  return updates.ok() ? saved : updates;
}

Status Scrubber::check_image(std::size_t bytes) {
  ImageCursor& at = work_.image;
  if (wiring_.image.empty() || workspace_.image_damaged) return {};
  for (std::size_t read = 0; read < bytes; read += chunk_bytes) {
    const std::span<const std::byte> region = wiring_.image[at.region];
    const std::size_t chunk = std::min(chunk_bytes, region.size() - at.offset);
    at.sum = checksum64(region.subspan(at.offset, chunk), at.sum);
    at.offset += chunk;
    if (at.offset < region.size()) continue;
    const bool same = at.sum == wiring_.image_sums[at.region];
    const auto number = static_cast<std::int64_t>(at.region);
    at = {(at.region + 1) % wiring_.image.size(), 0, 0};
    if (same) continue;
    workspace_.image_damaged = true;
    return {StatusCode::image_damaged, number};
  }
  return {};
}

StepResult Scrubber::step() {
  const TimeNs now = wiring_.clock.now();
  const TimeNs elapsed = work_.stepped ? now - work_.stepped_ns : 0;
  work_.stepped = true;
  work_.stepped_ns = now;
  const Status image = check_image(grant(wiring_.mission.image_check_bytes_per_s, elapsed, most_image_bytes));
  if (!image.ok()) return {image, false};
  return {check_store(grant(wiring_.mission.scrub_bytes_per_s, elapsed, most_store_bytes), now), false};
}

}  // namespace ilp
