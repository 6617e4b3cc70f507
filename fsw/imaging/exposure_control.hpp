// Chooses exposure and gain of the next image from the brightness of the present one.
#pragma once

#include <cstdint>

#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "hal/camera/camera.hpp"

namespace ilp {

/// Brightness of an image, measured on all pixels of every fourth row.
struct ImageBrightness {
  std::int32_t bright = 0;          ///< the largest grey value that at least 1 % of the pixels reach
  std::int32_t white_permille = 0;  ///< share of saturated pixels, 1/1000
};
[[nodiscard]] ImageBrightness measure_brightness(GrayView image);

struct ExposureGoal {
  std::int32_t bright_grey = 190;         ///< wanted ImageBrightness::bright
  std::int64_t longest_us = 20'000;       ///< bound of the exposure, motion blur included
  std::int64_t most_gain_milli = 64'000;  ///< bound of the gain
};

/// The exposure, us, during which the ground moves by `blur_px` in the image, at most `longest_us`. If `speed_px_s` is
/// 0 (not known) it is `longest_us`.
[[nodiscard]] std::int64_t longest_exposure_us(double blur_px, double speed_px_s, std::int64_t longest_us);

/// A controller in integer arithmetic. It brings ImageBrightness::bright to its goal with the least gain for which the
/// exposure stays within its bound. If the image is within an eighth of the goal, nothing is changed. One change is at
/// most a factor of four. When the direction of the changes alternates they are damped, down to an eighth, so that the
/// control converges even if the camera's gain follows another law than it states. An image that was taken with an
/// older setting than the requested one is ignored. If a setting has no effect on the image, the controller waits for
/// the next images and learns the camera's delay. Three settings in a row without an effect end the control.
class ExposureControl {
 public:
  enum class Answer : std::uint8_t { keep, change };

  void begin(const ExposureRange& range);
  [[nodiscard]] bool begun() const { return begun_; }
  /// Ends the control until the next begin(), because the camera cannot be controlled.
  void abandon() { begun_ = abandoned_ = true; }
  [[nodiscard]] bool abandoned() const { return abandoned_; }
  void reset() { *this = ExposureControl(); }

  /// Evaluates an image that was taken with the setting `taken_with`. If the answer is `change`, the caller sets `next`
  /// and then calls asked(). `event` becomes exposure_limited, exposure_not_obeyed or ok.
  Answer evaluate(const ImageBrightness& image, const ExposureSetting& taken_with, const ExposureGoal& goal,
                  ExposureSetting& next, Status& event);
  /// Notes the setting that the camera has chosen for `next`.
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
  ExposureSetting asked_;           ///< the requested setting; unknown before the first request
  ExposureSetting before_;          ///< setting of the image that led to the latest change
  std::int32_t bright_before_ = 0;  ///< ImageBrightness::bright of that image
  std::int32_t delay_ = 0;          ///< number of images after a change that do not show it
  std::int32_t waited_ = 0;         ///< number of images since the latest change
  std::int32_t without_effect_ = 0;
  std::int32_t direction_ = 0;  ///< direction of the latest change: -1 darker, 1 brighter
  std::int32_t damping_ = 0;
  std::int32_t limit_ = 0;   ///< reported limit; 0: none, 1: too dark, 2: too bright
  bool from_quiet_ = false;  ///< the latest change came long after the one before
  bool judged_ = true;       ///< an image has shown the effect of the latest change, or no image can
  bool begun_ = false;
  bool abandoned_ = false;
};

}  // namespace ilp
