#pragma once
// Makes the clay follow the deform box.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "engine/document/jobs.h"
#include "ui3d/studio/view/deform_box.h"

namespace argil::studio {

/// Works in the background on the clay as it was when the box was put around it, whenever box or numbers rest in
/// another place than the clay follows. However often that happens until the box is applied, it is one undo step. The
/// box is put away when the clay is changed by somebody else, or the piece goes. One thread.
class Deforming {
 public:
  using Edit = std::function<void(std::string label, std::function<void(engine::Document&)> change, std::string merge)>;
  /// Once a turn. `held`: a point of the box is in the hand. `edit` and `endMerge` are those of the workbench. True
  /// when something that is seen changed.
  bool update(std::optional<DeformBox>& box, const engine::Document& document, bool held, const Edit& edit,
              const std::function<void()>& endMerge);
  /// Clay is on its way.
  [[nodiscard]] bool busy() const { return job_ != nullptr || waits_; }

 private:
  struct Result {
    clay::Version version;
  };
  void begin(const DeformBox& box);
  void take(DeformBox& box, const Edit& edit);
  void show(const DeformBox& box, const clay::Version& version, const Edit& edit);
  void stop();

  std::optional<DeformBox> made_;    // What the clay, as it is shown, was made from.
  std::optional<DeformBox> making_;  // And what it is being made from.
  clay::Version shown_, before_;     // Sent to the document, and what it had until that arrives.
  bool waits_ = false;               // For it to arrive.
  uint64_t boxes_ = 0;               // Names the undo step.
  std::shared_ptr<Result> result_;
  std::unique_ptr<engine::BackgroundJob> job_;  // Last: it uses the others.
};

}  // namespace argil::studio
