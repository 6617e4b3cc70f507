// Compiled by a test: with ILP_IN_GROUPS it has to compile, with any other of these words the compiler has to refuse
// it.

#include "fsw/executive/stage_component.hpp"
#include "fsw/shared/checkpoint.hpp"

namespace ilp {

class Example final : public StageComponent<ComponentId::acquisition> {
 public:
  explicit Example(Tables store) : wiring_{store} {}
  Status restore() override { return {}; }
  StepResult step() override { return {}; }
  [[nodiscard]] LastingMemory lasting() const override {
    static_cast<void>(checkpoint_form<State>(component_id));
#ifdef ILP_FORGOTTEN_GROUP
    return LastingMemory::of(*this, wiring_, cursor_, state_);
#else
    return LastingMemory::of(*this, wiring_, cursor_, state_, work_);
#endif
  }

 private:
  struct Wiring {
    Tables store;
  };
  struct State {
    std::int64_t counted = 0;
#ifdef ILP_POINTER_IN_STATE
    const char* name = nullptr;
#endif
  };
  struct Work {
    std::int64_t waits = 0;
  };
#ifdef ILP_COUNTER_BEFORE_THEM
  bool counter_ = false;
#endif
  Wiring wiring_;
  Cursor cursor_;
  State state_;
  Work work_;
#ifdef ILP_COUNTER_BEHIND_THEM
  bool counter_ = false;
#endif
};

}  // namespace ilp
