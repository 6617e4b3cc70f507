// A start without a prior: the features of a keyframe are compared with those of all tiles, and the tiles that show the
// same ground say where to register it.
#pragma once

#include "fsw/localisation/map_part.hpp"

namespace ilp {

/// One call after another while work.phase is one of its phases. It ends with work.prior and FixPrior::search, and the
/// phase `load`, so that the keyframe is registered there; or with the phase `record`, where no tile shows its ground.
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
