#pragma once
// What runs while the studio is open. Parts: events (routing.cpp), pictures (showing.cpp), files (saving.cpp), the
// loop (studio.cpp).

#include <map>
#include <set>

#include "clay/base/error.h"
#include "engine/document/jobs.h"
#include "render/renderer/renderer.h"
#include "ui3d/studio/input/event_log.h"
#include "ui3d/studio/input/hand.h"
#include "ui3d/studio/input/pen.h"
#include "ui3d/studio/input/player.h"
#include "ui3d/studio/input/spacemouse_input.h"
#include "ui3d/studio/panels/actions.h"
#include "ui3d/studio/panels/panels.h"
#include "ui3d/studio/quick_ring.h"
#include "ui3d/studio/studio.h"
#include "ui3d/studio/ui_input.h"
#include "ui3d/studio/view/camera.h"
#include "ui3d/studio/view/deforming.h"
#include "ui3d/studio/view/frame_log.h"
#include "ui3d/studio/view/picture_thread.h"
#include "ui3d/studio/view/rest_sign.h"
#include "ui3d/studio/widgets/widgets.h"
#include "ui3d/studio/window.h"

namespace argil::studio {

/// Between two pictures the window's thread has the renderer and does everything; while one is drawn the picture thread
/// has it, and the window's thread only goes on with a stroke.
class SessionWindow {
 public:
  explicit SessionWindow(const StudioOptions& options);
  ~SessionWindow();
  SessionWindow(const SessionWindow&) = delete;
  SessionWindow& operator=(const SessionWindow&) = delete;
  void run();

 private:
  enum class Drag : uint8_t { none, panel, orbit, pan, stroke, line, widget, curve, click, ring, steer, size };

  // The loop (studio.cpp)
  void followStylus(double now);
  void followDeformBox();
  void gather();
  void turn();
  void serveRecording(double now);
  [[nodiscard]] bool acting() const;
  [[nodiscard]] bool atRest() const;
  void tellRest();
  [[nodiscard]] double restS(double now);
  void changed() { changedS_ = window_.nowS(); }
  void writeReport();
  /// A command that fails leaves a message, not the studio.
  template <class Command>
  void attempt(const Command& command) {
    try {
      command();
    } catch (const Error& e) {
      bench_.tell(engine::Message::Level::error, e.what());
    }
  }

  // Panels (studio.cpp)
  [[nodiscard]] Context context();
  void uiStep();
  void settleUi();
  void applyTheme();
  void serveWishes(Context& context);

  // Events (routing.cpp)
  void handle(const Event& event);
  bool handleQuickly(const Event& event);
  void press(const Event& event);
  void pressLeft(const Event& event, Context& context);
  void release(const Event& event);
  void move(const Event& event);
  void wheel(const Event& event);
  void key(const Event& event);
  void tapAlt(const Event& event);
  bool sizing(const Event& event);
  void scaleTool(const Event& event);
  bool pressSize(const Event& event);
  bool pressRing(const Event& event);
  void dragRing(const Event& event, float dx, float dy);
  void releaseRing(const Event& event);
  void takeTool(const Event& held);
  [[nodiscard]] bool toolDiffers(const Event& held);
  void holdKeys(const Event& held);
  bool waits(const Event& event);
  void hover();
  [[nodiscard]] Event inEye(Event event) const;
  [[nodiscard]] Camera::Ray ray(const Event& event) const;
  [[nodiscard]] Grip grip(const Event& event, bool down) const;
  [[nodiscard]] std::optional<render::Renderer::Hit> pick(const Camera::Ray& ray) const;
  [[nodiscard]] Vec3d under(const Event& event) const;
  [[nodiscard]] Hand::Stroke strokeHere() const;
  void endLine(const Event& event);
  void steer(const Event& event, bool down);
  void steerTo(const Vec3d& world, bool down);
  void workOnSelected();

  // Files (saving.cpp)
  void followFile();
  [[nodiscard]] render::Shot pictureShot();
  bool serveSave();
  bool servePicture();

  // Pictures (showing.cpp)
  bool collect();
  void takeSurfaces();
  void follow();
  void followPreview();
  void followToolSizes();
  [[nodiscard]] double viewSizeMm() const;
  void showWhole(bool glide);
  [[nodiscard]] std::optional<render::Cursor> cursor();
  [[nodiscard]] render::Shot shot();
  bool draw();
  void lost(const Error& error);
  void sendFont();

  StudioOptions options_;
  int64_t startNs_;
  StudioState state_;
  engine::Workbench bench_;
  std::optional<Player> player_;
  std::optional<EventWriter> recording_;
  Window window_;
  Pen pen_;
  SpaceMouseInput spaceMouse_;
  render::Renderer renderer_;
  UiInput ui_;
  Panels panels_;
  Widgets widgets_;
  Deforming deforming_;
  Camera camera_;
  Hand hand_;
  FrameLog log_;
  RestSign restSign_;

  std::shared_ptr<const engine::Snapshot> now_;
  std::vector<Event> events_;  // Waiting to be handled, in order.
  float width_ = 1280, height_ = 720, scale_ = 1;
  Theme themeShown_ = Theme::dark;
  float scaleShown_ = 0;
  int uiSteps_ = 2;                        // So many are to be done before the panels have settled.
  double uiS_ = 0, nextUiS_ = 0;           // Times of the last and of the next step.
  double changedS_ = 0;                    // When the picture changed last.
  double activeS_ = 0;                     // When the person did something last.
  double nextFrameS_ = 0, nextClayS_ = 0;  // No picture, and none of the clay, is drawn before.
  double tickS_ = 0, motionS_ = 0;

  // The hand on mouse and keyboard
  Event mouse_;  // Where it is.
  bool inWindow_ = false;
  Drag drag_ = Drag::none;
  Event dragFrom_;
  std::set<Button> held_;
  Vec3d pivot_ = Vec3d::Zero();
  double panDepthMm_ = 100;
  bool sizeKey_ = false, sizing_ = false, placing_ = false;
  double altS_ = -1;          // When Alt went down, below 0 where something else came since then.
  bool sizeDragged_ = false;  // Since F went down: motions without a button size no longer.
  double sizeFromMm_ = 1;
  float sizeFromX_ = 0;
  std::optional<render::Cursor::Footprint> footprint_;
  std::optional<Hand::Stroke> line_;     // A straight line that is being drawn from dragFrom_.
  Vec3d steeredAt_ = Vec3d::Zero();      // Where the hand of a simulated device was sent last, world.
  std::optional<Hand::Stroke> steered_;  // What the mouse that moves a simulated device meets, while it is pressed.
  std::optional<QuickRing> ring_;        // Open, until something of it was done or the hand presses beside it.
  QuickRing::Item ringItem_ = QuickRing::Item::none;
  bool ringClosed_ = false;  // By the press that is held.
  bool overWidget_ = false, hoverStale_ = true;
  std::optional<engine::Tool> toolSent_;
  double strokeS_ = -1e9;  // When a stroke was on last.

  SizeBy sizedBy_ = SizeBy::millimetres;  // As the sizes of the tools were followed last.
  bool sizeDue_ = false;                  // Another model is there, or will be when its surfaces are.
  std::optional<engine::Tool> faceTool_;  // That the document came with.

  // What the renderer has
  std::map<engine::Id, render::PieceLook> placed_;
  std::map<engine::Id, const void*> parts_;  // The mesh that was sent.
  std::set<engine::Id> seen_;                // Of the last document: one that has none of them is another.
  engine::SurfaceChanges waiting_;           // Taken, not yet sent.
  std::vector<std::pair<engine::Id, std::shared_ptr<const clay::TriangleMesh>>> partsWaiting_;
  engine::DocumentPtr placedFor_;
  std::optional<GrownPiece> placedGrown_;
  engine::Id placedWorked_ = 0;
  render::UiFrame panelsFrame_;
  uint64_t shotShown_ = 0, panelsShown_ = 0;
  bool stillShown_ = false;
  uint64_t madeShown_ = 0;  // Snapshot::madeCount,
  bool showMade_ = false;   // and whether its thing is still to be brought into the view.
  bool showAll_ = false;    // As soon as its surface is there.
  PictureCost cost_;
  FrameDone frame_;  // The picture thread's while it draws.
  double failedS_ = -1e9;
  size_t losses_ = 0;
  // Since the start: the first of what the file holds; all of it, as it was asked for.
  double firstPictureMs_ = 0, openedMs_ = 0;
  haptics::StylusSample stylus_;
  bool cuts_ = true;                                   // The stylus is on no widget.
  std::shared_ptr<const clay::TriangleMesh> preview_;  // Shown while it becomes clay.

  // The document's file
  uint64_t openedShown_ = 0;
  bool viewGiven_ = false;  // By the document: it is not to be shown as a whole.
  std::string titleShown_;
  std::filesystem::path pathShown_;
  std::filesystem::path pictureFile_;
  std::shared_ptr<render::Image> fileImage_;  // For pictureFile_: without pixels while it is drawn.
  std::unique_ptr<engine::BackgroundJob> pictureJob_;
  std::shared_ptr<std::vector<std::byte>> thumbnail_;  // Of a save that waits for it: a PNG once it is drawn.

  bool leave_ = false;
  size_t jobs_ = 0;
  PictureThread pictures_;  // Last: it uses the others.
};

}  // namespace argil::studio
