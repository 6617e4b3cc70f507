// The list of the kinds of image sources that ilp-onboard can use. A new kind is one more class in ImageSources.
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

  /// Holds the source that a flight uses, in the memory of the largest kind.
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
