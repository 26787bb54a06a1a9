#pragma once
// A ball that touches and cuts clay: the proxy and its force.

#include "haptics/contact/contact.h"
#include "haptics/contact/cutting.h"
#include "haptics/contact/friction.h"
#include "haptics/contact/guides.h"
#include "haptics/contact/proxy.h"
#include "haptics/contact/texture_path.h"
#include "haptics/scene/surroundings.h"

namespace argil::haptics {

/// A constraint proxy with friction on whatever the scene holds, and the cutting law where the tool changes clay.
/// Modes, tolerances and figures: NOTES.md, "Ball contact".
class BallContact final : public Contact {
 public:
  void reset() noexcept override;
  Output tick(const Scene& scene, const Input& input) ARGIL_REALTIME override;

  [[nodiscard]] const Proxy& proxy() const noexcept { return proxy_; }

 private:
  enum class Mode : uint8_t { touch, cut, settle, add };

  void changeMode(const Scene& scene, const Input& input) ARGIL_REALTIME;
  double stiffness(const Scene& scene, const Input& input) ARGIL_REALTIME;
  void touch(const Scene& scene, const Input& input, bool changed, Output& out) ARGIL_REALTIME;
  void cut(const Scene& scene, const Input& input, bool changed, Output& out) ARGIL_REALTIME;
  void lay(const Scene& scene, const Input& input, bool changed, Output& out) ARGIL_REALTIME;
  Vec3d spring(const Scene& scene, const Vec3d& hand, const Proxy::Holding& held, Output& out) ARGIL_REALTIME;
  void react(const Scene& scene, const Proxy::Holding& held, double stiffness, Output& out) const ARGIL_REALTIME;
  void go(const Vec3d& goal, const Input& input, const Proxy::Holding& held, Output& out) ARGIL_REALTIME;

  Guides guides_;
  Surroundings around_;
  Proxy proxy_;
  Friction friction_;
  TexturePath texture_;
  CutLaw law_;
  Mode mode_ = Mode::touch;
  bool begun_ = false;
  bool missed_ = false;  // What is known of the surface is old.
  double radius_ = 1;
  double stiffness_ = 0;               // Of what is touched, N/mm at the hand; eased from one material to the next.
  int touched_ = -1;                   // Thing that was touched last,
  Vec3d touchPoint_ = Vec3d::Zero();   // and where.
  Vec3d touchNormal_ = Vec3d::Zero();  // Of the last tick; zero when nothing was touched.
  double settleS_ = 0;
};

}  // namespace argil::haptics
