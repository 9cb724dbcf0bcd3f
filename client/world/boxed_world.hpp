// Bullet's world with bounding boxes that reach no farther than contacts do. Private to this folder.
#pragma once

#include <functional>

#include "client/world/bullet.hpp"

namespace fracture::world {

/// Bullet's own boxes reach 2 cm beyond each body, and another 5 cm in its tree, whatever the body's size. A
/// shard of a few centimetres then has dozens of neighbours to check in every step. The smaller boxes remove
/// a third of the pairs in a heap of 800 pieces, and three fifths among crates, but no contact.
class BoxedWorld final : public btDiscreteDynamicsWorld {
 public:
  BoxedWorld(btDispatcher* dispatcher, btBroadphaseInterface* boxes, btConstraintSolver* solver,
             btCollisionConfiguration* configuration);
  ~BoxedWorld() override;
  void updateAabbs() override;
  void calculateSimulationIslands() override;

  std::function<void()> when_contacts_are_found;  ///< called before they are solved
};

}  // namespace fracture::world
