//! The single fields that a bicycle may be described in. Their names are the bike file's keys, apart from the bicycle's own
//! name and its wheelbase.

/// The name of the bicycle: a part `bike` is a whole bike file.
pub const NAME: &str = "bike_name";
/// From the front wheel's centre to the rear wheel's; a bike file has its two parts.
pub const WHEELBASE: &str = "wheelbase_m";
/// One k and one B for both axles.
pub const EQUAL: &str = "equal_axles";

/// A number with its unit.
pub struct Field {
    pub name: &'static str,
    pub label: &'static str,
    pub unit: &'static str,
    /// An example.
    pub example: &'static str,
}

/// Fields that belong together.
pub struct Group {
    pub legend: &'static str,
    pub hint: &'static str,
    pub fields: &'static [Field],
    /// Whether most rides need them.
    pub needed: bool,
}

const fn field(
    name: &'static str,
    label: &'static str,
    unit: &'static str,
    example: &'static str,
) -> Field {
    Field {
        name,
        label,
        unit,
        example,
    }
}

pub const GROUPS: [Group; 5] = [
    Group {
        legend: "Masses",
        hint: "Mass carried by each wheel, rider included, as shown by a scale under each wheel. ± is the standard deviation, if \
               known; it is included in the intervals of k and B. Leave a mass blank only if a force channel determines it.",
        fields: &[
            field("mass_front_kg", "Front, m_F", "kg", "23.0"),
            field("mass_front_std_kg", "Front, ±", "kg", "0.2"),
            field("mass_rear_kg", "Rear, m_R", "kg", "63.0"),
            field("mass_rear_std_kg", "Rear, ±", "kg", "0.5"),
        ],
        needed: true,
    },
    Group {
        legend: "Lengths",
        hint: "Either the wheelbase, from which the distances are computed with the loads or masses on the wheels, or the \
               horizontal distances from the centre of gravity.",
        fields: &[
            field(WHEELBASE, "Wheelbase, L", "m", "1.10"),
            field("l_front_m", "To the front wheel, l_F", "m", "0.81"),
            field("l_rear_m", "To the rear wheel, l_R", "m", "0.29"),
        ],
        needed: true,
    },
    Group {
        legend: "Wheel radii",
        hint: "From the hub to the ground. Effects that turn with a wheel are found only if its radius is known.",
        fields: &[
            field("wheel_radius_front_m", "Front, r_F", "m", "0.34"),
            field("wheel_radius_rear_m", "Rear, r_R", "m", "0.34"),
        ],
        needed: false,
    },
    Group {
        legend: "Static loads",
        hint: "The wheels' load on the ground, if measured in newtons; otherwise it is computed from the masses.",
        fields: &[
            field("static_load_front_n", "Front, F_F", "N", "225.6"),
            field("static_load_rear_n", "Rear, F_R", "N", "608.2"),
        ],
        needed: false,
    },
    Group {
        legend: "Sensor noise",
        hint: "Standard deviation, if known.",
        fields: &[
            field("noise_displacement_m", "Displacement", "m", "0.00005"),
            field("noise_road_m", "Road", "m", "0.00005"),
        ],
        needed: false,
    },
];

/// The field for a number of this name.
pub fn number(name: &str) -> Option<&'static Field> {
    let all = GROUPS.iter().flat_map(|group| group.fields);
    all.into_iter().find(|field| field.name == name)
}

/// All of them.
pub fn names() -> impl Iterator<Item = &'static str> {
    let numbers = GROUPS.iter().flat_map(|group| group.fields);
    [NAME, EQUAL]
        .into_iter()
        .chain(numbers.map(|field| field.name))
}
