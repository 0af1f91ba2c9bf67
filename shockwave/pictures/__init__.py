"""Pictures of shocks, predictions, simulations and sweeps.

Each function takes data, draws them on the ``ax`` of the call or on a new figure, and returns the ``Axes``. `figure`
makes figures; `svg` and `save` write them; `style` has their settings, `METHODS` the colours of simulation, section 4,
shocks and warnings. The extra ``plot`` installs matplotlib, which is imported when something is drawn, not with this
package.
"""

from shockwave.base.arguments import explain_arguments as _explained
from shockwave.base.arguments import explain_types as _of_right_types
from shockwave.pictures.accuracy import approach as approach
from shockwave.pictures.accuracy import balance as balance
from shockwave.pictures.accuracy import work_precision as work_precision
from shockwave.pictures.figure_files import figure as figure
from shockwave.pictures.figure_files import save as save
from shockwave.pictures.figure_files import svg as svg
from shockwave.pictures.histories import record_keys as record_keys
from shockwave.pictures.histories import sensors as sensors
from shockwave.pictures.histories import shock_spectrum as shock_spectrum
from shockwave.pictures.picture_elements import METHODS as METHODS
from shockwave.pictures.picture_elements import style as style
from shockwave.pictures.shock import correction_area as correction_area
from shockwave.pictures.shock import pulse as pulse
from shockwave.pictures.studies import design as design
from shockwave.pictures.studies import distribution as distribution
from shockwave.pictures.studies import materials as materials
from shockwave.pictures.studies import pareto as pareto
from shockwave.pictures.studies import universal_curves as universal_curves
from shockwave.pictures.waves import contact_forces as contact_forces
from shockwave.pictures.waves import force_overlap as force_overlap
from shockwave.pictures.waves import peak_forces as peak_forces
from shockwave.pictures.waves import space_time as space_time
from shockwave.pictures.waves import train as train
from shockwave.pictures.waves import wall_force as wall_force

chain_map = space_time

for _name, _drawing in [*globals().items()]:
    if getattr(_drawing, "__module__", "").startswith("shockwave.pictures."):
        globals()[_name] = _explained(_of_right_types(_drawing))
del _name, _drawing, _explained, _of_right_types
