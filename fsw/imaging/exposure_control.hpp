// Chooses the exposure and the gain of the next image from the brightness of the present one.
#pragma once

#include <cstdint>

#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "hal/camera/camera.hpp"

namespace ilp {

/// Of every fourth row of an image, all pixels.
struct ImageBrightness {
  std::int32_t bright = 0;          ///< the largest grey value that at least a hundredth of the pixels reaches
  std::int32_t white_permille = 0;  ///< pixels that are white: what they show is lost
};
[[nodiscard]] ImageBrightness measure_brightness(GrayView image);

struct ExposureGoal {
  std::int32_t bright_grey = 190;         ///< wanted ImageBrightness::bright
  std::int64_t longest_us = 20'000;       ///< bound of the exposure, motion blur included
  std::int64_t most_gain_milli = 64'000;  ///< bound of the gain
};

/// Time in which the ground moves by `blur_px` in the image, at most `longest_us`; `speed_px_s` 0: not known.
[[nodiscard]] std::int64_t longest_exposure_us(double blur_px, double speed_px_s, std::int64_t longest_us);

/// Integer arithmetic. It aims at the least gain with which the exposure stays within its bound, and of that at the
/// shortest exposure that brings the bright end of the image to its goal. An image within an eighth of the goal is left
/// as it is. A change is at most a factor of four. After a change in the other direction than the one before, changes
/// are damped, down to an eighth, so that a camera whose gain has another law than it states converges too. An image
/// that was taken with an earlier setting than the one that was asked for is not judged. Where a setting shows no
/// effect in the image, the next images are waited for, and the camera's delay is learned; three settings in a row
/// without an effect end the control.
class ExposureControl {
 public:
  enum class Answer : std::uint8_t { keep, change };

  void begin(const ExposureRange& range);
  [[nodiscard]] bool begun() const { return begun_; }
  /// The control is over until the next begin(): the camera has no such control, or does not obey.
  void abandon() { begun_ = abandoned_ = true; }
  [[nodiscard]] bool abandoned() const { return abandoned_; }
  void reset() { *this = ExposureControl(); }

  /// `change`: `next` is to be set, and then told by asked(). `event`: exposure_limited or exposure_not_obeyed.
  Answer evaluate(const ImageBrightness& image, const ExposureSetting& taken_with, const ExposureGoal& goal,
                  ExposureSetting& next, Status& event);
  /// What the camera has made of `next`.
  void asked(const ExposureSetting& setting);

 private:
  struct Ratio {
    std::int64_t over = 1, under = 1;
  };
  [[nodiscard]] bool must_wait(const ImageBrightness& image, const ExposureSetting& taken_with, Status& event);
  [[nodiscard]] bool shows_effect(const ImageBrightness& image) const;
  [[nodiscard]] static Ratio correction(const ImageBrightness& image, const ExposureGoal& goal);
  [[nodiscard]] std::int64_t damped(std::int64_t product, const Ratio& wanted);
  [[nodiscard]] ExposureSetting share_out(std::int64_t product, const ExposureGoal& goal) const;
  void judge_limits(std::int64_t wanted, const ExposureSetting& next, Status& event);

  ExposureRange range_;
  ExposureSetting asked_;   ///< not known: nothing was asked for yet
  ExposureSetting before_;  ///< with which the image was taken that the change answers
  std::int32_t bright_before_ = 0;
  std::int32_t delay_ = 0;   ///< images after a change that do not show it
  std::int32_t waited_ = 0;  ///< images since the latest change
  std::int32_t without_effect_ = 0;
  std::int32_t direction_ = 0;  ///< of the latest change: -1 darker, 1 brighter
  std::int32_t damping_ = 0;
  std::int32_t limit_ = 0;   ///< 0: none, 1: too dark, 2: too bright
  bool from_quiet_ = false;  ///< the latest change was asked for when the one before was long past
  bool judged_ = true;       ///< the latest change was seen in an image, or cannot be
  bool begun_ = false;
  bool abandoned_ = false;
};

}  // namespace ilp
