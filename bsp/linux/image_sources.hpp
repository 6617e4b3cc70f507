// The kinds of cameras that ilp-onboard can fly with. A new kind is one class more in ImageSources.
#pragma once

#include <cstddef>
#include <variant>

#include "bsp/linux/recorded_strip.hpp"
#include "bsp/linux/stream_source.hpp"
#include "bsp/linux/video_source.hpp"

namespace ilp {

template <typename... Sources>
struct ImageSourceList {
  static constexpr ImageSourceKind kinds[] = {Sources::kind...};

  /// The one source of a flight.
  class Chosen {
   public:
    ImageSource& make(const ImageSourceKind& kind, const ImageSourceContext& context) {
      (make_if<Sources>(kind, context), ...);
      return *source_;
    }
    [[nodiscard]] ImageSource& operator*() const { return *source_; }
    [[nodiscard]] ImageSource* operator->() const { return source_; }

   private:
    template <typename Source>
    void make_if(const ImageSourceKind& kind, const ImageSourceContext& context) {
      if (kind.option == Source::kind.option) source_ = &memory_.template emplace<Source>(context);
    }

    std::variant<std::monostate, Sources...> memory_;
    ImageSource* source_ = nullptr;
  };
};

using ImageSources = ImageSourceList<RecordedStrip, VideoSource, StreamSource>;

}  // namespace ilp
