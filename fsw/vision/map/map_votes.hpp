// Patches of a sheet, and what their votes for a shift are worth.
#pragma once

#include <span>

#include "fsw/base/verdicts.hpp"
#include "fsw/vision/map/keyframe_sheet.hpp"
#include "fsw/vision/map/map_workspace.hpp"

namespace ilp {

/// Chooses patches without overlap, of which nine tenths count in the sheet, where the grid holds most of them. Of more
/// than fit, evenly spread ones. Uses `sums` as scratch. Returns their number.
std::int32_t choose_patches(const MapChannels<max_map_sheet_side>& sheet, std::int32_t side,
                            MapRegistrationWorkspace& workspace);

/// Sums of the surfaces of all patches, by quarter.
class VoteSurfaces {
 public:
  VoteSurfaces(MapRegistrationWorkspace& workspace, std::int32_t lags) : workspace_(workspace), lags_(lags) {}

  void clear();
  /// Takes the patch's surface: its own best place and the sum. Returns the number of lags at which the map is known;
  /// 0, and takes nothing, when these are less than half, or when it agrees with none of them.
  std::int32_t add(MapPatch& patch);
  /// Sum of the quarters that the bits of `which` name.
  [[nodiscard]] std::int64_t at(std::uint32_t which, std::int32_t column, std::int32_t row) const;
  struct Peak {
    std::int32_t column = 0, row = 0;      ///< lag
    double fine_column = 0, fine_row = 0;  ///< to a part of a pixel
  };
  /// The first of the highest.
  [[nodiscard]] Peak peak(std::uint32_t which) const;
  static constexpr std::uint32_t all = 15;

 private:
  MapRegistrationWorkspace& workspace_;
  std::int32_t lags_;
};

struct MapVote {
  MapVerdict verdict = MapVerdict::no_texture;
  std::int32_t column = 0, row = 0;  ///< lag of the peak
  double fine_column = 0, fine_row = 0;
  double evidence = 0;
  std::int32_t patches = 0, votes = 0, rivals = 0, quarters = 0;
};
/// -ln of the chance that `votes` or more of `patches` are within a pixel of one shift, times the number of places that
/// a patch may take: binomial, each with the chance 9 / lags. May be below 0.
[[nodiscard]] double vote_evidence(std::int32_t votes, std::int32_t patches, double lags);
/// The verdict on the surfaces of the patches that are used. `lags`: mean number of lags at which a patch can be.
[[nodiscard]] MapVote count_votes(std::span<const MapPatch> patches, const VoteSurfaces& surfaces, std::int32_t side,
                                  double lags, double min_evidence);

/// Place of the largest value of a parabola through three, -1/2 to 1/2 from the middle one.
[[nodiscard]] double vertex(double before, double middle, double after);

}  // namespace ilp
