// A start without a prior: compares the features of a keyframe with those of all tiles, and takes the position of the
// tiles that show the same ground as the prior of the registration.
#pragma once

#include "fsw/localisation/map_part.hpp"

namespace ilp {

/// Call the function of the present work.phase in each step. The start ends with work.prior, FixPrior::search and the
/// phase `load`, so that the keyframe is registered there; or with the phase `record` if no tile shows its ground.
class MapStart {
 public:
  MapStart(const MapWiring& wiring, MapWork& work, MapWorkspace& workspace)
      : wiring_(wiring), work_(work), workspace_(workspace) {}

  void begin() {
    work_.phase = MapPhase::start_image;
    work_.keeps = false;
  }
  Status load_image();
  Status find_features();
  Status compare();

 private:
  [[nodiscard]] MapStartScratch& scratch() const { return wiring_.scratch.as<MapStartScratch>(); }
  [[nodiscard]] std::int32_t reduction() const;
  Status compare_from(std::size_t entry);
  void add_features(std::size_t entry, std::int32_t rows, std::int32_t columns);
  void conclude();

  const MapWiring& wiring_;
  MapWork& work_;
  MapWorkspace& workspace_;
};

}  // namespace ilp
